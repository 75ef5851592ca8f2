// Meshes of an object, put together.
#pragma once

#include "clients/formats/mesh_file.h"
#include "cwm/v1/geometry.pb.h"

namespace cwm::cli {

// The mesh in another frame: p_A = X_AB p_B. The quaternion is taken as of unit length.
formats::MeshFile Transformed(const cwm::v1::Pose& x_a_b, formats::MeshFile mesh_b);

// Both in one, vertices of `more` after those of `mesh`.
void Append(const formats::MeshFile& more, formats::MeshFile& mesh);

}  // namespace cwm::cli
