#include "server/wire/shapes.h"

#include <string>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/coefficients.h"
#include "collision/geometry/validation.h"
#include "server/core/error.h"
#include "server/wire/numbers.h"
#include "server/wire/poses.h"

namespace cwm::server {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

Polygon PolygonFromProto(const v1::Polygon& polygon) {
  Polygon vertices;
  vertices.reserve(polygon.vertices_size());
  for (const v1::Vector2& vertex : polygon.vertices())
    vertices.emplace_back(vertex.x(), vertex.y());
  return vertices;
}

// Sets the vertices of a polygon or the points of a profile.
void SetPlaces(const std::vector<Vector2>& places,
               google::protobuf::RepeatedPtrField<v1::Vector2>* proto) {
  for (const Vector2& place : places) {
    v1::Vector2* added = proto->Add();
    added->set_x(place.x());
    added->set_y(place.y());
  }
}

void SetPolygon(const Polygon& polygon, v1::Polygon* proto) {
  SetPlaces(polygon, proto->mutable_vertices());
}

// The stored mesh; an error names the field of the hash.
absl::StatusOr<StoredMesh> FindMesh(const std::string& hash, const GeometryStore& store,
                                    const FieldPath& path) {
  const FieldPath hash_path = path.Field("hash");
  if (hash.empty()) return hash_path.Error("is empty, must name a mesh stored by WriteGeometry");
  auto stored = store.FindMesh(hash);
  if (!stored.ok()) {
    ErrorDetails details = DetailsOf(stored.status());
    details.fields.push_back(
        {hash_path.str(), absl::StrCat("is ", hash, ", names nothing stored")});
    return MakeError(stored.status().code(),
                     absl::StrCat(hash_path.str(), ": is ", hash, ", names nothing stored"),
                     std::move(details));
  }
  if (stored->mesh == nullptr) {
    return hash_path.Error(absl::StrCat("is ", hash, ", must name a mesh, names another format"));
  }
  return stored;
}

absl::StatusOr<Shape> HullOf(const v1::Convex& convex, const GeometryStore& store,
                             const FieldPath& path, WorkBudget* budget) {
  const auto stored = FindMesh(convex.hash(), store, path);
  if (!stored.ok()) return stored.status();
  const std::size_t count = stored->mesh->vertices.size();
  if (count > kMaxHullInputVertices) {
    return path.Field("hash").Error(absl::StrCat("names a mesh of ", count,
                                                 " vertices, must have at most ",
                                                 kMaxHullInputVertices, " for a hull"));
  }
  const MeshHull* const hull = stored->facts->HullOf(stored->mesh, budget);
  if (hull == nullptr) return budget->status();
  if (!hull->fault.empty()) return path.Field("hash").Error(hull->fault);
  return Shape(Convex{hull->hull != nullptr ? hull->hull : stored->mesh});
}

absl::StatusOr<Mesh> MeshOf(const std::string& hash, const GeometryStore& store,
                            const FieldPath& path, WorkBudget* budget) {
  const auto stored = FindMesh(hash, store, path);
  if (!stored.ok()) return stored.status();
  std::optional<Mesh> solid = stored->facts->SolidOf(stored->mesh, budget);
  if (!solid) return budget->status();
  return *std::move(solid);
}

Shape PlateOf(const v1::Plate& plate) {
  Plate shape{.outline = PolygonFromProto(plate.outline()),
              .holes = {},
              .thickness_m = plate.thickness_m()};
  for (const v1::Polygon& hole : plate.holes()) shape.holes.push_back(PolygonFromProto(hole));
  return shape;
}

// Steps of a WorkBudget for checking whether a plate's outline crosses itself: a few milliseconds
// for the largest plate.
constexpr std::size_t kStepsOfPlate = std::size_t{1} << 16;

// The validation rules name "outline[3].x" and "holes[1][3].x"; the messages have a field
// `vertices` in between.
std::string MessageField(std::string field) {
  if (const auto at = field.find("]["); at != std::string::npos) field.insert(at + 1, ".vertices");
  constexpr std::string_view kOutline = "outline";
  if (field.starts_with("outline[")) field.insert(kOutline.size(), ".vertices");
  return field;
}

// Checks the validation rules of shapes; `name` is the alternative of the oneof.
absl::StatusOr<Shape> Validated(Shape shape, const FieldPath& path, WorkBudget* budget) {
  // A plate of thousands of vertices takes a millisecond, everything else less than one step.
  const bool is_plate = std::holds_alternative<Plate>(shape);
  if (MustEnd(budget, is_plate ? kStepsOfPlate : 1)) return budget->status();
  const std::string_view name = NameOf(KindOf(shape));
  if (const auto violation = FindViolation(shape)) {
    const std::string field = MessageField(violation->field);
    const FieldPath shape_path = path.Field(name);
    return shape_path.Field(field).Error(
        absl::StrCat("is ", violation->value, ", ", violation->rule));
  }
  return shape;
}

// `M` is any message with the oneof `shape`.
template <class M>
absl::StatusOr<Shape> ShapeOf(const M& m, const GeometryStore& store, const FieldPath& path,
                              WorkBudget* budget) {
  switch (m.shape_case()) {
    case M::kSphere:
      return Validated(Sphere{m.sphere().radius_m()}, path, budget);
    case M::kBox:
      return Validated(Box{{m.box().size_x_m(), m.box().size_y_m(), m.box().size_z_m()}}, path,
                       budget);
    case M::kCylinder:
      return Validated(Cylinder{m.cylinder().radius_m(), m.cylinder().length_m()}, path, budget);
    case M::kCone:
      return Validated(
          Cone{m.cone().radius_bottom_m(), m.cone().radius_top_m(), m.cone().length_m()}, path,
          budget);
    case M::kCapsule:
      return Validated(Capsule{m.capsule().radius_m(), m.capsule().length_m()}, path, budget);
    case M::kHalfSpace:
      return Shape(HalfSpace{});
    case M::kPlate:
      return Validated(PlateOf(m.plate()), path, budget);
    case M::kConvex:
      return HullOf(m.convex(), store, path.Field("convex"), budget);
    case M::kMesh: {
      auto mesh = MeshOf(m.mesh().hash(), store, path.Field("mesh"), budget);
      if (!mesh.ok()) return mesh.status();
      return Shape(*std::move(mesh));
    }
    case M::SHAPE_NOT_SET:
      break;
  }
  return path.Field("shape").Error(
      "is absent, must be one of sphere, box, cylinder, cone, capsule, half_space, plate, convex, "
      "mesh");
}

template <class M>
void SetShape(const Shape& shape, GeometryStore& store, M* m) {
  std::visit(Overloaded{
                 [m](const Sphere& s) { m->mutable_sphere()->set_radius_m(s.radius_m); },
                 [m](const Box& s) {
                   m->mutable_box()->set_size_x_m(s.size_m.x());
                   m->mutable_box()->set_size_y_m(s.size_m.y());
                   m->mutable_box()->set_size_z_m(s.size_m.z());
                 },
                 [m](const Cylinder& s) {
                   m->mutable_cylinder()->set_radius_m(s.radius_m);
                   m->mutable_cylinder()->set_length_m(s.length_m);
                 },
                 [m](const Cone& s) {
                   m->mutable_cone()->set_radius_bottom_m(s.radius_bottom_m);
                   m->mutable_cone()->set_radius_top_m(s.radius_top_m);
                   m->mutable_cone()->set_length_m(s.length_m);
                 },
                 [m](const Capsule& s) {
                   m->mutable_capsule()->set_radius_m(s.radius_m);
                   m->mutable_capsule()->set_length_m(s.length_m);
                 },
                 [m](const HalfSpace&) { m->mutable_half_space(); },
                 [m](const Plate& s) {
                   SetPolygon(s.outline, m->mutable_plate()->mutable_outline());
                   for (const Polygon& hole : s.holes)
                     SetPolygon(hole, m->mutable_plate()->add_holes());
                   m->mutable_plate()->set_thickness_m(s.thickness_m);
                 },
                 [m, &store](const Convex& s) {
                   m->mutable_convex()->set_hash(store.RegisterMesh(s.hull));
                 },
                 [m, &store](const Mesh& s) { m->mutable_mesh()->set_hash(store.RegisterMesh(s)); },
             },
             shape);
}

v1::FitQuality FitToProto(const FitQuality& fit) {
  v1::FitQuality proto;
  proto.set_rms_m(fit.rms_m);
  proto.set_max_residual_m(fit.max_residual_m);
  proto.set_inlier_count(fit.inlier_count);
  proto.set_inlier_ratio(fit.inlier_ratio);
  proto.set_observed_fraction(fit.observed_fraction);
  proto.mutable_parameter_sigma()->Assign(fit.parameter_sigma.begin(), fit.parameter_sigma.end());
  return proto;
}

v1::Vessel VesselToProto(const VesselShell& shell) {
  v1::Vessel proto;
  proto.set_rim_radius_m(shell.rim_radius_m());
  proto.set_foot_radius_m(shell.foot_radius_m());
  proto.set_height_m(shell.height_m());
  proto.set_depth_m(shell.depth_m());
  proto.set_wall_thickness_m(shell.wall_thickness_m);
  if (shell.rim_radius_sigma_m) proto.set_rim_radius_sigma_m(*shell.rim_radius_sigma_m);
  if (shell.wall_thickness_sigma_m) {
    proto.set_wall_thickness_sigma_m(*shell.wall_thickness_sigma_m);
  }
  SetPlaces(shell.outer, proto.mutable_outer_profile());
  SetPlaces(shell.inner, proto.mutable_inner_profile());
  return proto;
}

// The pose, or identity if it is not given.
absl::StatusOr<Pose> OptionalPose(bool given, const v1::Pose& pose, const FieldPath& path) {
  if (!given) return Pose::Identity();
  return PoseFromProto(pose, path);
}

}  // namespace

absl::StatusOr<Placed<>> PlacedShapeFromProto(const v1::PlacedShape& placed,
                                              const GeometryStore& store, const FieldPath& path,
                                              WorkBudget* budget) {
  auto X_BS =
      OptionalPose(placed.has_x_body_shape(), placed.x_body_shape(), path.Field("x_body_shape"));
  if (!X_BS.ok()) return X_BS.status();
  auto shape = ShapeOf(placed, store, path, budget);
  if (!shape.ok()) return shape.status();
  return Placed<>{*X_BS, *std::move(shape)};
}

namespace {

absl::StatusOr<Placed<Box>> OrientedBoxFromProto(const v1::OrientedBox& proto,
                                                 const FieldPath& path, WorkBudget* budget) {
  auto X_OB =
      OptionalPose(proto.has_x_object_box(), proto.x_object_box(), path.Field("x_object_box"));
  if (!X_OB.ok()) return X_OB.status();
  const v1::Box& box = proto.box();
  auto shape = Validated(Box{{box.size_x_m(), box.size_y_m(), box.size_z_m()}}, path, budget);
  if (!shape.ok()) return shape.status();
  return Placed<Box>{.X_FS = *X_OB, .shape = std::get<Box>(*shape)};
}

}  // namespace

absl::StatusOr<ShapePart> ShapePartFromProto(const v1::ShapePart& part, const GeometryStore& store,
                                             const FieldPath& path, WorkBudget* budget) {
  auto X_OS =
      OptionalPose(part.has_x_object_shape(), part.x_object_shape(), path.Field("x_object_shape"));
  if (!X_OS.ok()) return X_OS.status();
  auto shape = ShapeOf(part, store, path, budget);
  if (!shape.ok()) return shape.status();
  if (!v1::PartRole_IsValid(part.role())) {
    return path.Field("role").Error(absl::StrCat(
        "is ", static_cast<int>(part.role()), ", must be PART_ROLE_FITTED or PART_ROLE_COMPLETED"));
  }
  ShapePart result{
      .X_OS = *X_OS,
      .shape = *std::move(shape),
      .role = part.role() == v1::PART_ROLE_COMPLETED ? PartRole::kCompleted : PartRole::kFitted,
      .fit = std::nullopt};
  if (part.has_hidden()) {
    auto hidden = OrientedBoxFromProto(part.hidden(), path.Field("hidden"), budget);
    if (!hidden.ok()) return hidden.status();
    result.hidden = *std::move(hidden);
  }
  return result;
}

absl::StatusOr<SurfacePart> SurfacePartFromProto(const v1::SurfacePart& part,
                                                 const GeometryStore& store, const FieldPath& path,
                                                 WorkBudget* budget) {
  auto mesh = MeshOf(part.hash(), store, path, budget);
  if (!mesh.ok()) return mesh.status();
  return SurfacePart{.surface = *std::move(mesh), .point_count = 0};
}

v1::PlacedShape PlacedShapeToProto(const Placed<>& placed, GeometryStore& store) {
  v1::PlacedShape proto;
  *proto.mutable_x_body_shape() = PoseToProto(placed.X_FS);
  SetShape(placed.shape, store, &proto);
  return proto;
}

v1::ShapePart ShapePartToProto(const ShapePart& part, GeometryStore& store) {
  v1::ShapePart proto;
  *proto.mutable_x_object_shape() = PoseToProto(part.X_OS);
  SetShape(part.shape, store, &proto);
  proto.set_role(part.role == PartRole::kCompleted ? v1::PART_ROLE_COMPLETED
                                                   : v1::PART_ROLE_FITTED);
  const std::vector<double> coefficients = Coefficients(part.shape, part.X_OS);
  proto.mutable_coefficients()->Assign(coefficients.begin(), coefficients.end());
  if (part.fit.has_value()) *proto.mutable_fit() = FitToProto(*part.fit);
  if (part.vessel != nullptr) *proto.mutable_vessel() = VesselToProto(*part.vessel);
  if (part.hidden) *proto.mutable_hidden() = OrientedBoxToProto(*part.hidden);
  return proto;
}

v1::SurfacePart SurfacePartToProto(const SurfacePart& part, GeometryStore& store) {
  v1::SurfacePart proto;
  proto.set_hash(store.RegisterMesh(part.surface.mesh));
  proto.set_vertex_count(static_cast<std::int64_t>(part.surface.mesh->vertices.size()));
  proto.set_triangle_count(static_cast<std::int64_t>(part.surface.mesh->triangles.size()));
  proto.set_watertight(part.surface.watertight);
  proto.set_point_count(part.point_count);
  return proto;
}

v1::OrientedBox OrientedBoxToProto(const Placed<Box>& box) {
  v1::OrientedBox proto;
  *proto.mutable_x_object_box() = PoseToProto(box.X_FS);
  proto.mutable_box()->set_size_x_m(box.shape.size_m.x());
  proto.mutable_box()->set_size_y_m(box.shape.size_m.y());
  proto.mutable_box()->set_size_z_m(box.shape.size_m.z());
  return proto;
}

}  // namespace cwm::server
