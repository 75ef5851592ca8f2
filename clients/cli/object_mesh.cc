#include "clients/cli/object_mesh.h"

#include <optional>
#include <string>

#include "absl/strings/str_cat.h"
#include "clients/cli/mesh_frames.h"
#include "clients/cpp/geometry_transfer.h"
#include "collision/geometry/tessellate.h"

namespace cwm::cli {
namespace {

namespace pb = cwm::v1;

Polygon PolygonOf(const pb::Polygon& polygon) {
  Polygon vertices;
  for (const pb::Vector2& vertex : polygon.vertices()) {
    vertices.emplace_back(vertex.x(), vertex.y());
  }
  return vertices;
}

Box BoxOf(const pb::Box& box) {
  return {.size_m = Vector3(box.size_x_m(), box.size_y_m(), box.size_z_m())};
}

Plate PlateOf(const pb::Plate& plate) {
  Plate shape{
      .outline = PolygonOf(plate.outline()), .holes = {}, .thickness_m = plate.thickness_m()};
  for (const pb::Polygon& hole : plate.holes()) shape.holes.push_back(PolygonOf(hole));
  return shape;
}

// Nothing for shapes that are meshes by themselves.
std::optional<Shape> ShapeOf(const pb::ShapePart& part) {
  switch (part.shape_case()) {
    case pb::ShapePart::kSphere:
      return Sphere{.radius_m = part.sphere().radius_m()};
    case pb::ShapePart::kBox:
      return BoxOf(part.box());
    case pb::ShapePart::kCylinder:
      return Cylinder{.radius_m = part.cylinder().radius_m(),
                      .length_m = part.cylinder().length_m()};
    case pb::ShapePart::kCone:
      return Cone{.radius_bottom_m = part.cone().radius_bottom_m(),
                  .radius_top_m = part.cone().radius_top_m(),
                  .length_m = part.cone().length_m()};
    case pb::ShapePart::kCapsule:
      return Capsule{.radius_m = part.capsule().radius_m(), .length_m = part.capsule().length_m()};
    case pb::ShapePart::kHalfSpace:
      return HalfSpace{};
    case pb::ShapePart::kPlate:
      return PlateOf(part.plate());
    case pb::ShapePart::kConvex:
    case pb::ShapePart::kMesh:
    case pb::ShapePart::SHAPE_NOT_SET:
      break;
  }
  return std::nullopt;
}

formats::MeshFile Tessellated(const Shape& shape) {
  const TriangleMesh mesh = Tessellate(shape);
  formats::MeshFile file;
  file.vertices.reserve(mesh.vertices.size());
  for (const Vector3& vertex : mesh.vertices) {
    file.vertices.push_back({vertex.x(), vertex.y(), vertex.z()});
  }
  file.triangles = mesh.triangles;
  return file;
}

absl::StatusOr<formats::MeshFile> Fetched(const client::Connection& connection,
                                          const std::string& hash) {
  const auto blob = client::ReadGeometry(connection, hash);
  if (!blob.ok()) return blob.status();
  return client::DecodeMesh(blob->bytes);
}

absl::StatusOr<formats::MeshFile> MeshOf(const client::Connection& connection,
                                         const pb::ShapePart& part) {
  const std::optional<Shape> shape = ShapeOf(part);
  auto mesh =
      shape ? Tessellated(*shape)
            : Fetched(connection, part.has_mesh() ? part.mesh().hash() : part.convex().hash());
  if (!mesh.ok() || !part.has_x_object_shape()) return mesh;
  return Transformed(part.x_object_shape(), *std::move(mesh));
}

absl::StatusOr<formats::MeshFile> MeshOf(const client::Connection& connection,
                                         const pb::Handle& handle) {
  if (!handle.hash().empty()) return Fetched(connection, handle.hash());
  return Transformed(handle.bounds().x_object_box(), Tessellated(BoxOf(handle.bounds().box())));
}

absl::StatusOr<formats::MeshFile> MeshOf(const client::Connection& connection,
                                         const pb::SurfacePart& surface) {
  return Fetched(connection, surface.hash());
}

template <class Parts>
absl::Status AppendAll(const client::Connection& connection, const Parts& parts,
                       formats::MeshFile& all) {
  for (const auto& part : parts) {
    const auto mesh = MeshOf(connection, part);
    if (!mesh.ok()) return mesh.status();
    Append(*mesh, all);
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<formats::MeshFile> MeshOf(const client::Connection& connection,
                                         const pb::Object& object) {
  formats::MeshFile all;
  absl::Status status = AppendAll(connection, object.shapes(), all);
  if (status.ok()) status = AppendAll(connection, object.surfaces(), all);
  if (status.ok()) status = AppendAll(connection, object.handles(), all);
  if (!status.ok()) return status;
  if (all.triangles.empty()) {
    return absl::NotFoundError(absl::StrCat(object.name(), " has no part that could be a mesh"));
  }
  return Transformed(object.x_world_object(), std::move(all));
}

}  // namespace cwm::cli
