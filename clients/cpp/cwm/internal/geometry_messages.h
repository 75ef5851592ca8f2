// Poses, shapes and meshes as messages and back.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>
#include <vector>

#include "clients/formats/mesh_file.h"
#include "cwm/objects.h"
#include "cwm/shapes.h"
#include "cwm/v1/geometry.pb.h"
#include "cwm/v1/world.pb.h"

namespace cwm::CWM_API::internal {

// tx ty tz qx qy qz qw. Throws kInvalidArgument with the name for what is no rigid transform, to
// within 1e-3.
std::array<double, 7> PoseNumbers(const Eigen::Isometry3d& X, const std::string& name);
Eigen::Isometry3d PoseFromNumbers(const double* numbers);

v1::Pose ToMessage(const Eigen::Isometry3d& X, const std::string& name);
// An absent pose is the identity.
Eigen::Isometry3d FromMessage(const v1::Pose& pose);
Eigen::Vector3d FromMessage(const v1::Vector3& vector);
void SetVector(const Eigen::Vector3d& vector, v1::Vector3& message);
OrientedBox FromMessage(const v1::OrientedBox& box);
Vessel FromMessage(const v1::Vessel& vessel);

// A mesh as it travels, which the server must have before a shape can name it.
struct MeshBlob {
  std::string hash;
  std::string bytes;
};
MeshBlob EncodeMesh(const Mesh& mesh);
// Without the hash.
Mesh MeshFrom(const formats::MeshFile& file);

// Set the shape of the message, and append the meshes that it needs.
void SetShape(const Shape& shape, v1::PlacedShape& message, std::vector<MeshBlob>& meshes);
void SetShape(const Shape& shape, v1::ShapePart& message, std::vector<MeshBlob>& meshes);
Shape ShapeFrom(const v1::ShapePart& message);

}  // namespace cwm::CWM_API::internal
