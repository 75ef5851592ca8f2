#include "cwm/internal/geometry_messages.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>
#include <variant>

#include "absl/strings/str_cat.h"
#include "cwm/internal/session.h"
#include "proto/transfer/sha256.h"

namespace cwm::CWM_API::internal {
namespace {

// chosen: the server's tolerance of a quaternion's length.
constexpr double kRotationTolerance = 1e-3;

void SetPolygon(const Polygon& polygon, v1::Polygon& message) {
  for (const auto& corner : polygon.colwise()) {
    v1::Vector2& vertex = *message.add_vertices();
    vertex.set_x(corner.x());
    vertex.set_y(corner.y());
  }
}

template <class Vertices>
Polygon PolygonFrom(const Vertices& vertices) {
  Polygon polygon(2, vertices.size());
  for (int i = 0; i < vertices.size(); ++i) polygon.col(i) << vertices[i].x(), vertices[i].y();
  return polygon;
}

std::string HashOf(const Mesh& mesh, std::vector<MeshBlob>& meshes) {
  if (mesh.vertices.size() == 0 && !mesh.hash.empty()) return mesh.hash;
  meshes.push_back(EncodeMesh(mesh));
  return meshes.back().hash;
}

template <class Message>
void Set(const Shape& shape, Message& message, std::vector<MeshBlob>& meshes) {
  std::visit(
      [&](const auto& value) {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, Sphere>) {
          message.mutable_sphere()->set_radius_m(value.radius_m);
        } else if constexpr (std::is_same_v<T, Box>) {
          message.mutable_box()->set_size_x_m(value.size_x_m);
          message.mutable_box()->set_size_y_m(value.size_y_m);
          message.mutable_box()->set_size_z_m(value.size_z_m);
        } else if constexpr (std::is_same_v<T, Cylinder>) {
          message.mutable_cylinder()->set_radius_m(value.radius_m);
          message.mutable_cylinder()->set_length_m(value.length_m);
        } else if constexpr (std::is_same_v<T, Capsule>) {
          message.mutable_capsule()->set_radius_m(value.radius_m);
          message.mutable_capsule()->set_length_m(value.length_m);
        } else if constexpr (std::is_same_v<T, Cone>) {
          message.mutable_cone()->set_radius_bottom_m(value.radius_bottom_m);
          message.mutable_cone()->set_radius_top_m(value.radius_top_m);
          message.mutable_cone()->set_length_m(value.length_m);
        } else if constexpr (std::is_same_v<T, HalfSpace>) {
          message.mutable_half_space();
        } else if constexpr (std::is_same_v<T, Plate>) {
          SetPolygon(value.outline, *message.mutable_plate()->mutable_outline());
          for (const Polygon& hole : value.holes) {
            SetPolygon(hole, *message.mutable_plate()->add_holes());
          }
          message.mutable_plate()->set_thickness_m(value.thickness_m);
        } else if constexpr (std::is_same_v<T, Convex>) {
          message.mutable_convex()->set_hash(HashOf(value, meshes));
        } else {
          message.mutable_mesh()->set_hash(HashOf(value, meshes));
        }
      },
      shape);
}

}  // namespace

std::array<double, 7> PoseNumbers(const Eigen::Isometry3d& X, const std::string& name) {
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Vector3d p = X.translation();
  if (!R.allFinite() || !p.allFinite()) ThrowBadArgument(name, "has a number that is not finite");
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (error > kRotationTolerance || R.determinant() < 0) {
    ThrowBadArgument(name,
                     "is no rigid transform, its rotation must be orthonormal and "
                     "right-handed");
  }
  const Eigen::Quaterniond q = Eigen::Quaterniond(R).normalized();
  return {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
}

Eigen::Isometry3d PoseFromNumbers(const double* numbers) {
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation() << numbers[0], numbers[1], numbers[2];
  const Eigen::Quaterniond q(numbers[6], numbers[3], numbers[4], numbers[5]);
  if (q.norm() > 0) X.linear() = q.normalized().toRotationMatrix();
  return X;
}

v1::Pose ToMessage(const Eigen::Isometry3d& X, const std::string& name) {
  const std::array<double, 7> numbers = PoseNumbers(X, name);
  v1::Pose pose;
  pose.set_tx_m(numbers[0]);
  pose.set_ty_m(numbers[1]);
  pose.set_tz_m(numbers[2]);
  pose.set_qx(numbers[3]);
  pose.set_qy(numbers[4]);
  pose.set_qz(numbers[5]);
  pose.set_qw(numbers[6]);
  return pose;
}

Eigen::Isometry3d FromMessage(const v1::Pose& pose) {
  const std::array<double, 7> numbers = {pose.tx_m(), pose.ty_m(), pose.tz_m(), pose.qx(),
                                         pose.qy(),   pose.qz(),   pose.qw()};
  return PoseFromNumbers(numbers.data());
}

Eigen::Vector3d FromMessage(const v1::Vector3& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

void SetVector(const Eigen::Vector3d& vector, v1::Vector3& message) {
  message.set_x(vector.x());
  message.set_y(vector.y());
  message.set_z(vector.z());
}

OrientedBox FromMessage(const v1::OrientedBox& box) {
  return {.size = {box.box().size_x_m(), box.box().size_y_m(), box.box().size_z_m()},
          .X_OB = FromMessage(box.x_object_box())};
}

Vessel FromMessage(const v1::Vessel& vessel) {
  Vessel value{.rim_radius_m = vessel.rim_radius_m(),
               .foot_radius_m = vessel.foot_radius_m(),
               .height_m = vessel.height_m(),
               .depth_m = vessel.depth_m(),
               .wall_thickness_m = vessel.wall_thickness_m(),
               .rim_radius_sigma_m = {},
               .wall_thickness_sigma_m = {},
               .outer_profile = PolygonFrom(vessel.outer_profile()),
               .inner_profile = PolygonFrom(vessel.inner_profile())};
  if (vessel.has_rim_radius_sigma_m()) value.rim_radius_sigma_m = vessel.rim_radius_sigma_m();
  if (vessel.has_wall_thickness_sigma_m()) {
    value.wall_thickness_sigma_m = vessel.wall_thickness_sigma_m();
  }
  return value;
}

MeshBlob EncodeMesh(const Mesh& mesh) {
  static_assert(sizeof(std::uint32_t) == sizeof(Triangles::Scalar));
  const std::array<std::uint32_t, 2> counts = {static_cast<std::uint32_t>(mesh.vertices.cols()),
                                               static_cast<std::uint32_t>(mesh.triangles.cols())};
  MeshBlob blob;
  const auto append = [&](const void* data, std::size_t size) {
    if (size > 0) blob.bytes.append(static_cast<const char*>(data), size);
  };
  append(counts.data(), sizeof(counts));
  append(mesh.vertices.data(), static_cast<std::size_t>(mesh.vertices.size()) * sizeof(double));
  append(mesh.triangles.data(),
         static_cast<std::size_t>(mesh.triangles.size()) * sizeof(std::uint32_t));
  blob.hash = Sha256Hex(blob.bytes);
  return blob;
}

Mesh MeshFrom(const formats::MeshFile& file) {
  Mesh mesh;
  mesh.vertices.resize(3, static_cast<Eigen::Index>(file.vertices.size()));
  mesh.triangles.resize(3, static_cast<Eigen::Index>(file.triangles.size()));
  for (Eigen::Index i = 0; i < mesh.vertices.cols(); ++i) {
    const auto& vertex = file.vertices[static_cast<std::size_t>(i)];
    mesh.vertices.col(i) << vertex[0], vertex[1], vertex[2];
  }
  for (Eigen::Index i = 0; i < mesh.triangles.cols(); ++i) {
    const auto& triangle = file.triangles[static_cast<std::size_t>(i)];
    mesh.triangles.col(i) << triangle[0], triangle[1], triangle[2];
  }
  return mesh;
}

void SetShape(const Shape& shape, v1::PlacedShape& message, std::vector<MeshBlob>& meshes) {
  Set(shape, message, meshes);
}

void SetShape(const Shape& shape, v1::ShapePart& message, std::vector<MeshBlob>& meshes) {
  Set(shape, message, meshes);
}

Shape ShapeFrom(const v1::ShapePart& message) {
  using Part = v1::ShapePart;
  switch (message.shape_case()) {
    case Part::kSphere:
      return Sphere{message.sphere().radius_m()};
    case Part::kBox:
      return Box{message.box().size_x_m(), message.box().size_y_m(), message.box().size_z_m()};
    case Part::kCylinder:
      return Cylinder{message.cylinder().radius_m(), message.cylinder().length_m()};
    case Part::kCone:
      return Cone{message.cone().radius_bottom_m(), message.cone().radius_top_m(),
                  message.cone().length_m()};
    case Part::kCapsule:
      return Capsule{message.capsule().radius_m(), message.capsule().length_m()};
    case Part::kHalfSpace:
      return HalfSpace{};
    case Part::kPlate: {
      Plate plate{.outline = PolygonFrom(message.plate().outline().vertices()),
                  .thickness_m = message.plate().thickness_m(),
                  .holes = {}};
      for (const v1::Polygon& hole : message.plate().holes()) {
        plate.holes.push_back(PolygonFrom(hole.vertices()));
      }
      return plate;
    }
    case Part::kConvex: {
      Convex convex;
      convex.hash = message.convex().hash();
      return convex;
    }
    case Part::kMesh:
    case Part::SHAPE_NOT_SET:
      break;
  }
  return Mesh{.vertices = {}, .triangles = {}, .hash = message.mesh().hash()};
}

}  // namespace cwm::CWM_API::internal
