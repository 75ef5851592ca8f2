#include <cmath>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/world/robot_transaction.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/store/decode_fault.h"
#include "server/store/decode_values.h"

namespace cwm::server {
namespace {

using Doubles = google::protobuf::RepeatedField<double>;
using MeshPtr = std::shared_ptr<const TriangleMesh>;

std::string Indexed(const char* list, int index) { return absl::StrCat(list, "[", index, "]"); }

absl::Status CheckCount(const Doubles& numbers, int count, std::string_view field) {
  if (numbers.size() == count) return absl::OkStatus();
  return Broken(field, absl::StrCat("has ", numbers.size(), " numbers, must have ", count));
}

absl::Status CheckFinite(std::initializer_list<double> values, std::string_view field) {
  for (const double value : values) {
    if (!std::isfinite(value)) return Broken(field, "has a number that is not finite");
  }
  return absl::OkStatus();
}

absl::StatusOr<Vector3> DecodeVector(const Doubles& numbers, std::string_view field) {
  if (absl::Status status = CheckCount(numbers, 3, field); !status.ok()) return status;
  const Vector3 vector(numbers[0], numbers[1], numbers[2]);
  if (!vector.allFinite()) return Broken(field, "has a number that is not finite");
  return vector;
}

absl::StatusOr<std::vector<Vector2>> DecodePoints(const store::v1::Polygon& polygon,
                                                  std::string_view field) {
  const Doubles& numbers = polygon.xy_m();
  if (numbers.size() % 2 != 0) {
    return Broken(field, absl::StrCat("has ", numbers.size(), " numbers, must have two a point"));
  }
  std::vector<Vector2> points;
  points.reserve(static_cast<std::size_t>(numbers.size() / 2));
  for (int i = 0; i < numbers.size(); i += 2) {
    points.emplace_back(numbers[i], numbers[i + 1]);
    if (!points.back().allFinite()) return Broken(field, "has a number that is not finite");
  }
  return points;
}

// nullptr for a mesh without content.
absl::StatusOr<MeshPtr> ContentOf(const store::v1::Mesh& mesh, const MeshContents& contents) {
  if (mesh.content_case() == store::v1::Mesh::CONTENT_NOT_SET) return MeshPtr();
  return contents(mesh);
}

absl::StatusOr<MeshCap> DecodeCap(const store::v1::Cap& cap) {
  if (absl::Status status = CheckCount(cap.axis_m(), 6, "axis_m"); !status.ok()) return status;
  MeshCap decoded;
  for (int i = 0; i < 6; ++i) decoded.axis[static_cast<std::size_t>(i / 3)][i % 3] = cap.axis_m(i);
  decoded.radius_m = cap.radius_m();
  decoded.diameter_m = cap.diameter_m();
  if (!decoded.axis[0].allFinite() || !decoded.axis[1].allFinite()) {
    return Broken("axis_m", "has a number that is not finite");
  }
  if (auto status = CheckFinite({cap.radius_m(), cap.diameter_m()}, "radius_m"); !status.ok()) {
    return status;
  }
  return decoded;
}

absl::StatusOr<Mesh> DecodeMeshShape(const store::v1::Mesh& mesh, const MeshContents& contents) {
  absl::StatusOr<MeshPtr> content = ContentOf(mesh, contents);
  if (!content.ok()) return content.status();
  Mesh decoded{.mesh = *std::move(content), .watertight = mesh.watertight()};
  if (!mesh.has_caps()) return decoded;
  std::vector<MeshCap> caps;
  for (int i = 0; i < mesh.caps_size(); ++i) {
    absl::StatusOr<MeshCap> cap = DecodeCap(mesh.caps(i));
    if (!cap.ok()) return Within(Indexed("caps", i), cap.status());
    caps.push_back(*std::move(cap));
  }
  decoded.caps = std::make_shared<const std::vector<MeshCap>>(std::move(caps));
  return decoded;
}

absl::StatusOr<Shape> DecodePlate(const store::v1::Plate& plate) {
  absl::StatusOr<Polygon> outline = DecodePoints(plate.outline(), "outline");
  if (!outline.ok()) return outline.status();
  Plate decoded{.outline = *std::move(outline), .holes = {}, .thickness_m = plate.thickness_m()};
  for (const store::v1::Polygon& hole : plate.holes()) {
    absl::StatusOr<Polygon> points = DecodePoints(hole, "holes");
    if (!points.ok()) return points.status();
    decoded.holes.push_back(*std::move(points));
  }
  return Shape(std::move(decoded));
}

template <class Make>
absl::StatusOr<Shape> FromNumbers(const store::v1::Numbers& numbers, int count, const Make& make) {
  const absl::Status status = CheckCount(numbers.values(), count, "values");
  return status.ok() ? absl::StatusOr<Shape>(make(numbers.values())) : status;
}

absl::StatusOr<Shape> DecodeUnchecked(const store::v1::Shape& shape, const MeshContents& contents) {
  switch (shape.kind_case()) {
    case store::v1::Shape::kSphereRadiusM:
      return Shape(Sphere{shape.sphere_radius_m()});
    case store::v1::Shape::kBox:
      return FromNumbers(shape.box(), 3,
                         [](const Doubles& n) { return Box{Vector3(n[0], n[1], n[2])}; });
    case store::v1::Shape::kCylinder:
      return FromNumbers(shape.cylinder(), 2, [](const Doubles& n) {
        return Cylinder{n[0], n[1]};
      });
    case store::v1::Shape::kCone:
      return FromNumbers(shape.cone(), 3, [](const Doubles& n) { return Cone{n[0], n[1], n[2]}; });
    case store::v1::Shape::kCapsule:
      return FromNumbers(shape.capsule(), 2, [](const Doubles& n) { return Capsule{n[0], n[1]}; });
    case store::v1::Shape::kHalfSpace:
      return Shape(HalfSpace{});
    case store::v1::Shape::kPlate:
      return DecodePlate(shape.plate());
    case store::v1::Shape::kConvex: {
      absl::StatusOr<MeshPtr> hull = ContentOf(shape.convex(), contents);
      if (!hull.ok()) return hull.status();
      return Shape(Convex{*std::move(hull)});
    }
    case store::v1::Shape::kMesh: {
      absl::StatusOr<Mesh> mesh = DecodeMeshShape(shape.mesh(), contents);
      if (!mesh.ok()) return mesh.status();
      return Shape(*std::move(mesh));
    }
    case store::v1::Shape::KIND_NOT_SET:
      break;
  }
  return Broken("kind", "is absent, must be that of a shape");
}

absl::Status CheckShape(const Shape& shape) {
  const std::optional<Violation> violation = FindViolation(shape);
  if (!violation) return absl::OkStatus();
  return Broken(violation->field, absl::StrCat("is ", violation->value, ", ", violation->rule));
}

absl::StatusOr<Shape> DecodeShape(const store::v1::Shape& shape, const MeshContents& contents) {
  absl::StatusOr<Shape> decoded = DecodeUnchecked(shape, contents);
  if (!decoded.ok()) return decoded;
  const absl::Status status = CheckShape(*decoded);
  return status.ok() ? decoded : status;
}

// A box of which a side may have no length.
absl::StatusOr<Placed<Box>> DecodeBox(const store::v1::PlacedBox& box) {
  absl::StatusOr<Pose> X_FS = DecodePose(box.x_fs());
  if (!X_FS.ok()) return Within("x_fs", X_FS.status());
  absl::StatusOr<Vector3> size_m = DecodeVector(box.size_m(), "size_m");
  if (!size_m.ok()) return size_m.status();
  if (size_m->minCoeff() < 0) return Broken("size_m", "is negative, must not be");
  return Placed<Box>{.X_FS = *X_FS, .shape = {.size_m = *size_m}};
}

absl::StatusOr<FitQuality> DecodeFit(const store::v1::FitQuality& fit) {
  FitQuality decoded{
      .rms_m = fit.rms_m(),
      .max_residual_m = fit.max_residual_m(),
      .inlier_count = fit.inlier_count(),
      .inlier_ratio = fit.inlier_ratio(),
      .observed_fraction = fit.observed_fraction(),
      .parameter_sigma = {fit.parameter_sigma().begin(), fit.parameter_sigma().end()}};
  for (const double sigma : decoded.parameter_sigma) {
    if (std::isnan(sigma)) return Broken("parameter_sigma", "has a number that is not one");
  }
  return decoded;
}

absl::StatusOr<std::shared_ptr<const VesselShell>> DecodeVessel(
    const store::v1::VesselShell& shell) {
  auto decoded = std::make_shared<VesselShell>();
  for (const auto& [points, polygon, field] :
       {std::tuple(&decoded->outer, &shell.outer(), "outer"),
        std::tuple(&decoded->inner, &shell.inner(), "inner")}) {
    absl::StatusOr<std::vector<Vector2>> read = DecodePoints(*polygon, field);
    if (!read.ok()) return read.status();
    if (read->size() < 2) return Broken(field, "has less than two points");
    *points = *std::move(read);
  }
  decoded->wall_thickness_m = shell.wall_thickness_m();
  if (shell.has_rim_radius_sigma_m()) decoded->rim_radius_sigma_m = shell.rim_radius_sigma_m();
  if (shell.has_wall_thickness_sigma_m()) {
    decoded->wall_thickness_sigma_m = shell.wall_thickness_sigma_m();
  }
  return decoded;
}

absl::StatusOr<ShapePart> DecodePart(const store::v1::ShapePart& part,
                                     const MeshContents& contents) {
  ShapePart decoded;
  absl::StatusOr<Pose> X_OS = DecodePose(part.x_os());
  if (!X_OS.ok()) return Within("x_os", X_OS.status());
  decoded.X_OS = *X_OS;
  absl::StatusOr<Shape> shape = DecodeShape(part.shape(), contents);
  if (!shape.ok()) return Within("shape", shape.status());
  decoded.shape = *std::move(shape);
  decoded.role = part.completed() ? PartRole::kCompleted : PartRole::kFitted;
  if (part.has_fit()) {
    absl::StatusOr<FitQuality> fit = DecodeFit(part.fit());
    if (!fit.ok()) return Within("fit", fit.status());
    decoded.fit = *std::move(fit);
  }
  if (part.has_vessel()) {
    auto vessel = DecodeVessel(part.vessel());
    if (!vessel.ok()) return Within("vessel", vessel.status());
    decoded.vessel = *std::move(vessel);
  }
  if (part.has_hidden()) {
    absl::StatusOr<Placed<Box>> hidden = DecodeBox(part.hidden());
    if (!hidden.ok()) return Within("hidden", hidden.status());
    decoded.hidden = *std::move(hidden);
  }
  return decoded;
}

// A surface may have no triangles.
absl::StatusOr<Mesh> DecodeSurface(const store::v1::Mesh& mesh, const MeshContents& contents) {
  absl::StatusOr<Mesh> decoded = DecodeMeshShape(mesh, contents);
  const bool is_empty =
      decoded.ok() && (decoded->mesh == nullptr || decoded->mesh->triangles.empty());
  if (!decoded.ok() || is_empty) return decoded;
  const absl::Status status = CheckShape(Shape(*decoded));
  return status.ok() ? decoded : status;
}

absl::StatusOr<Handle> DecodeHandle(const store::v1::Handle& handle, int shape_count,
                                    const MeshContents& contents) {
  Handle decoded;
  decoded.shape_index = handle.shape_index();
  decoded.point_count = handle.point_count();
  if (decoded.shape_index < -1 || decoded.shape_index >= shape_count) {
    return Broken("shape_index", absl::StrCat("is ", decoded.shape_index, ", must be from -1 to ",
                                              shape_count - 1));
  }
  absl::StatusOr<Vector3> axis_O = DecodeVector(handle.axis_o(), "axis_o");
  if (!axis_O.ok()) return axis_O.status();
  decoded.axis_O = *axis_O;
  absl::StatusOr<Placed<Box>> bounds = DecodeBox(handle.bounds());
  if (!bounds.ok()) return Within("bounds", bounds.status());
  decoded.bounds = *std::move(bounds);
  absl::StatusOr<Mesh> surface = DecodeSurface(handle.surface(), contents);
  if (!surface.ok()) return Within("surface", surface.status());
  decoded.surface = *std::move(surface);
  return decoded;
}

}  // namespace

absl::StatusOr<Pose> DecodePose(const store::v1::Pose& pose) {
  if (auto status = CheckCount(pose.matrix(), 12, "matrix"); !status.ok()) return status;
  Pose X_AB = Pose::Identity();
  for (int i = 0; i < 12; ++i) X_AB.matrix()(i / 4, i % 4) = pose.matrix(i);
  if (!collision::IsPlaceable(X_AB)) {
    return Broken("matrix", "must be a rotation and a place within 1e6 m of the origin");
  }
  return X_AB;
}

absl::StatusOr<MeshPtr> DecodeContent(std::string_view mesh_f64) {
  absl::StatusOr<TriangleMesh> mesh = ReadMeshColumns<TriangleMesh>(mesh_f64);
  if (!mesh.ok()) return Broken("mesh_f64", std::string(mesh.status().message()));
  return std::make_shared<const TriangleMesh>(*std::move(mesh));
}

absl::StatusOr<std::shared_ptr<const HybridModel>> DecodeModel(const store::v1::Model& model,
                                                               const MeshContents& contents) {
  auto decoded = std::make_shared<HybridModel>();
  for (int i = 0; i < model.shapes_size(); ++i) {
    absl::StatusOr<ShapePart> part = DecodePart(model.shapes(i), contents);
    if (!part.ok()) return Within(Indexed("shapes", i), part.status());
    decoded->shapes.push_back(*std::move(part));
  }
  for (int i = 0; i < model.surfaces_size(); ++i) {
    absl::StatusOr<Mesh> surface = DecodeSurface(model.surfaces(i).surface(), contents);
    if (!surface.ok()) return Within(Indexed("surfaces", i), surface.status());
    decoded->surfaces.push_back(
        {.surface = *std::move(surface), .point_count = model.surfaces(i).point_count()});
  }
  for (int i = 0; i < model.handles_size(); ++i) {
    absl::StatusOr<Handle> handle = DecodeHandle(model.handles(i), model.shapes_size(), contents);
    if (!handle.ok()) return Within(Indexed("handles", i), handle.status());
    decoded->handles.push_back(*std::move(handle));
  }
  decoded->point_count = model.point_count();
  return decoded;
}

}  // namespace cwm::server
