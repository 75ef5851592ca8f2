#include "perception/scene/support_polygon.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "collision/geometry/polygon.h"

namespace cwm::perception {
namespace {

// The outline is exact to half of this; finer than what a sensor resolves at a table's edge.
constexpr double kOutlineStep_m = 0.005;

// z along the normal, x the projection of the parent's x (of its y, where x is the normal itself).
Matrix3 LevelBasis(const Vector3& normal) {
  Vector3 x = Vector3::UnitX() - normal.x() * normal;
  if (x.norm() < 0.1) x = Vector3::UnitY() - normal.y() * normal;
  x.normalize();
  Matrix3 basis;
  basis << x, normal.cross(x), normal;
  return basis;
}

// Leftmost and rightmost point of each row of a raster: enough for the hull, few enough to sort.
std::vector<Vector2> RowEnds(const std::vector<Vector2>& points) {
  std::map<long, std::pair<Vector2, Vector2>> rows;
  for (const Vector2& p : points) {
    const auto [row, is_new] =
        rows.try_emplace(std::lround(p.y() / kOutlineStep_m), std::pair{p, p});
    if (is_new) continue;
    if (p.x() < row->second.first.x()) row->second.first = p;
    if (p.x() > row->second.second.x()) row->second.second = p;
  }
  std::vector<Vector2> ends;
  for (const auto& [key, row] : rows) {
    ends.push_back(row.first);
    ends.push_back(row.second);
  }
  return ends;
}

}  // namespace

std::optional<Placed<Plate>> MakeSupportPlate(const Plane& plane, const OrientedPoints& points,
                                              std::span<const std::uint32_t> members) {
  const Matrix3 basis = LevelBasis(plane.normal);
  std::vector<Vector2> projected;
  projected.reserve(members.size());
  for (std::uint32_t i : members) {
    const Vector3 p = points.points[i].cast<double>();
    projected.emplace_back(basis.col(0).dot(p), basis.col(1).dot(p));
  }
  Polygon outline = ConvexHull(RowEnds(projected));
  if (outline.size() < 3 || SignedArea_m2(outline) < kOutlineStep_m * kOutlineStep_m) {
    return std::nullopt;
  }
  Eigen::AlignedBox2d bounds;
  for (const Vector2& v : outline) bounds.extend(v);
  const Vector2 middle = bounds.center();
  for (Vector2& v : outline) v -= middle;
  Placed<Plate> placed;
  placed.shape = {.outline = std::move(outline), .holes = {}, .thickness_m = kPlateThickness_m};
  placed.X_FS.linear() = basis;
  placed.X_FS.translation() =
      basis.col(0) * middle.x() + basis.col(1) * middle.y() + plane.normal * plane.offset_m;
  return placed;
}

double OutsideOutline_m(const Placed<Plate>& plate, const Vector3& point) {
  const Vector3 local = plate.X_FS.inverse(Eigen::Isometry) * point;
  const Vector2 p = local.head<2>();
  const double distance = (NearestOnBorder(plate.shape.outline, p) - p).norm();
  return Contains(plate.shape.outline, p) ? -distance : distance;
}

}  // namespace cwm::perception
