#include "server/export/planner_shape.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/tessellate.h"

namespace cwm::server {
namespace {

using Kind = PlannerPrimitive::Kind;

// derived: the largest distance of a plate's corners from those of a rectangle: a nanometre, the
// smallest dimension that shapes have.
constexpr double kRectangleTolerance_m = 1e-9;

// The rectangle of an outline: its frame, with x and y along its sides, and its size.
struct Rectangle {
  Vector2 centre;
  double angle_rad = 0;  // of its x axis
  Vector2 size_m;
};

std::optional<Rectangle> RectangleOf(const Polygon& outline) {
  if (outline.size() != 4) return std::nullopt;
  const Vector2 x = outline[1] - outline[0];
  const Vector2 y = outline[3] - outline[0];
  const Vector2 fourth = outline[1] + outline[3] - outline[0];
  // The cosine of the corner times the longer side is the distance of that side's end from square.
  const double skew_m = std::abs(x.dot(y)) / std::min(x.norm(), y.norm());
  if (!((fourth - outline[2]).norm() <= kRectangleTolerance_m && skew_m <= kRectangleTolerance_m)) {
    return std::nullopt;
  }
  return Rectangle{.centre = 0.5 * (outline[0] + outline[2]),
                   .angle_rad = x.y() == 0 && x.x() > 0 ? 0 : std::atan2(x.y(), x.x()),
                   .size_m = {x.norm(), y.norm()}};
}

PlannerPrimitive BoxOf(const Vector3& size_m) {
  return {.kind = Kind::kBox,
          .dimensions_m = {size_m.x(), size_m.y(), size_m.z()},
          .dimension_count = 3};
}

PlannerPrimitive RoundPrimitive(Kind kind, double length_m, double radius_m) {
  return {.kind = kind, .dimensions_m = {length_m, radius_m, 0}, .dimension_count = 2};
}

struct Converter {
  PlannerShape& result;

  void Mesh(const Shape& shape, const std::string& what) const {
    result.shape = std::make_shared<const TriangleMesh>(Tessellate(shape));
    const double inside_mm = 1e3 * DeviationBound_m(shape);
    result.note = absl::StrCat(what, " written as a mesh");
    // Rounded up to a hundredth of a millimetre.
    if (inside_mm > 0) {
      absl::StrAppend(&result.note, ", up to ", std::ceil(100 * inside_mm) / 100,
                      " mm inside of it");
    }
  }

  void operator()(const Sphere& s) const {
    result.shape = PlannerPrimitive{
        .kind = Kind::kSphere, .dimensions_m = {s.radius_m, 0, 0}, .dimension_count = 1};
  }
  void operator()(const Box& s) const { result.shape = BoxOf(s.size_m); }
  void operator()(const Cylinder& s) const {
    result.shape = RoundPrimitive(Kind::kCylinder, s.length_m, s.radius_m);
  }
  void operator()(const Cone& s) const {
    if (s.radius_top_m == s.radius_bottom_m) {
      result.shape = RoundPrimitive(Kind::kCylinder, s.length_m, s.radius_top_m);
    } else if (s.radius_top_m == 0) {
      result.shape = RoundPrimitive(Kind::kCone, s.length_m, s.radius_bottom_m);
    } else if (s.radius_bottom_m == 0) {
      result.shape = RoundPrimitive(Kind::kCone, s.length_m, s.radius_top_m);
      result.X_OS = result.X_OS * Pose(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()));
    } else {
      Mesh(s, "a truncated cone is");
    }
  }
  void operator()(const Capsule& s) const { Mesh(s, "a capsule is"); }
  void operator()(const HalfSpace&) const {
    result.shape = PlannerPlane{};
    result.note = "a half-space is written as a plane: a planner may take its surface alone";
  }
  void operator()(const Plate& s) const {
    const auto rectangle = s.holes.empty() ? RectangleOf(s.outline) : std::nullopt;
    if (!rectangle) return Mesh(s, "a plate is");
    Pose X_SB = MakeTranslation(rectangle->centre.x(), rectangle->centre.y(), -0.5 * s.thickness_m);
    X_SB.linear() = Eigen::AngleAxisd(rectangle->angle_rad, Vector3::UnitZ()).toRotationMatrix();
    result.X_OS = result.X_OS * X_SB;
    result.shape = BoxOf({rectangle->size_m.x(), rectangle->size_m.y(), s.thickness_m});
  }
  // A hull is a closed mesh, so it needs no note.
  void operator()(const Convex& s) const { result.shape = s.hull; }
  void operator()(const cwm::Mesh& s) const { result.shape = s.mesh; }
};

}  // namespace

PlannerShape ToPlannerShape(const Placed<Shape>& part) {
  PlannerShape result;
  result.X_OS = part.X_FS;
  std::visit(Converter{result}, part.shape);
  return result;
}

}  // namespace cwm::server
