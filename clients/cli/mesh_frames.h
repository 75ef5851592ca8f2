// Transforms points and meshes to another frame.
#pragma once

#include <array>

#include "clients/formats/mesh_file.h"
#include "cwm/v1/geometry.pb.h"

namespace cwm::cli {

// A point or a mesh in another frame: p_A = X_AB p_B. The quaternion must have unit length.
std::array<double, 3> TransformPoint(const cwm::v1::Pose& x_a_b, const std::array<double, 3>& p_b);
formats::MeshFile TransformMesh(const cwm::v1::Pose& x_a_b, formats::MeshFile mesh_b);

}  // namespace cwm::cli
