#include "collision/kernels/plane_profile.h"

#include <algorithm>
#include <cmath>

#include "collision/kernels/kink.h"

namespace cwm::collision {
namespace {

// Share of the size. Nearer to a corner than this, the direction away from it is lost in the
// rounding of poses (as in signed_distance.cc).
constexpr double kProfileRoundoff = 1e-11;

Vector2 OutwardNormal(const ProfileEdge& edge) { return {edge.out_x, edge.out_y}; }

}  // namespace

PlaneProfile PlaneProfile::Revolved(std::span<const Vector2> points) {
  PlaneProfile profile;
  profile.AddChain(points, /*closed=*/false, /*solid_on_left=*/true);
  return profile;
}

PlaneProfile PlaneProfile::Outline(const Plate& plate) {
  PlaneProfile profile;
  profile.AddChain(plate.outline, /*closed=*/true, SignedArea_m2(plate.outline) > 0);
  for (const Polygon& hole : plate.holes) {
    profile.AddChain(hole, /*closed=*/true, SignedArea_m2(hole) < 0);
  }
  return profile;
}

void PlaneProfile::AddChain(std::span<const Vector2> points, bool closed, bool solid_on_left) {
  const std::size_t first = edges_.size();
  const std::size_t count = closed ? points.size() : points.size() - 1;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector2 &a = points[i], &b = points[(i + 1) % points.size()];
    size_m_ = std::max({size_m_, a.cwiseAbs().maxCoeff(), b.cwiseAbs().maxCoeff()});
    const Vector2 along = b - a;
    const double length_m = along.norm();
    if (!(length_m > 0)) continue;
    const double side = (solid_on_left ? 1 : -1) / length_m;
    edges_.push_back({.a_x = a.x(),
                      .a_y = a.y(),
                      .along_x = along.x(),
                      .along_y = along.y(),
                      .inverse_length_m2 = 1 / (length_m * length_m),
                      .out_x = side * along.y(),
                      .out_y = -side * along.x(),
                      .slope = along.y() == 0 ? 0 : along.x() / along.y(),
                      .previous = static_cast<std::int32_t>(edges_.size()) - 1,
                      .has_next = true});
  }
  if (edges_.size() == first) return;
  edges_[first].previous = closed ? static_cast<std::int32_t>(edges_.size()) - 1 : -1;
  edges_.back().has_next = closed;
}

double PlaneProfile::ParameterOf(const ProfileEdge& edge, const Vector2& p) {
  return ((p.x() - edge.a_x) * edge.along_x + (p.y() - edge.a_y) * edge.along_y) *
         edge.inverse_length_m2;
}

PlaneProfile::Projection PlaneProfile::ProjectOn(const ProfileEdge& edge, const Vector2& p) {
  const double way = ParameterOf(edge, p);
  const double on_edge = std::clamp(way, 0.0, 1.0);
  const Vector2 offset(p.x() - edge.a_x - on_edge * edge.along_x,
                       p.y() - edge.a_y - on_edge * edge.along_y);
  return {way, offset, std::sqrt(offset.squaredNorm())};
}

bool PlaneProfile::IsLocallyNearest(const ProfileEdge& edge, const Projection& projection,
                                    const Vector2& p) const {
  if (projection.way > 1) return !edge.has_next;
  if (projection.way >= 0 || edge.previous < 0) return true;
  return ParameterOf(edges_[static_cast<std::size_t>(edge.previous)], p) > 1;
}

Vector2 PlaneProfile::GradientAt(const ProfileEdge& edge, const Projection& projection,
                                 double sign) const {
  const bool at_corner = projection.way < 0 || projection.way > 1;
  if (at_corner && projection.distance_m > kProfileRoundoff * size_m_) {
    return sign * projection.offset / projection.distance_m;
  }
  return OutwardNormal(edge);
}

// True if the distance has a kink at p: an edge that is about as near as the nearest one has
// another gradient. On the border all edges at p count; elsewhere only those on which the
// projection is locally nearest.
bool PlaneProfile::IsKink(const Vector2& p, const PlaneSample& nearest, double sign) const {
  const double distance_m = std::abs(nearest.distance_m);
  const bool on_border = distance_m <= kKinkTolerance_m;
  return std::any_of(edges_.begin(), edges_.end(), [&](const ProfileEdge& edge) {
    const Projection projection = ProjectOn(edge, p);
    if (projection.distance_m > distance_m + kKinkTolerance_m) return false;
    if (!on_border && !IsLocallyNearest(edge, projection, p)) return false;
    const Vector2 other = on_border ? OutwardNormal(edge) : GradientAt(edge, projection, sign);
    return (other - nearest.gradient).squaredNorm() > kGradientTolerance * kGradientTolerance;
  });
}

PlaneSample PlaneProfile::Sample(const Vector2& p) const {
  Projection nearest;
  nearest.distance_m = NearestLanes::kNone;
  const ProfileEdge* at = nullptr;
  int within_reach = 0;  // edges about as near as the nearest; above 1, IsKink decides
  bool inside = false;
  for (const ProfileEdge& edge : edges_) {
    const bool crosses = (edge.a_y > p.y()) != (edge.a_y + edge.along_y > p.y());
    inside ^= crosses && p.x() - edge.a_x < (p.y() - edge.a_y) * edge.slope;
    const Projection projection = ProjectOn(edge, p);
    if (projection.distance_m <= nearest.distance_m + kKinkTolerance_m) {
      const bool parts_ways = projection.distance_m < nearest.distance_m - kKinkTolerance_m;
      within_reach = parts_ways ? 1 : within_reach + 1;
    }
    if (projection.distance_m >= nearest.distance_m) continue;
    nearest = projection;
    at = &edge;
  }
  const double sign = inside ? -1 : 1;
  PlaneSample sample{sign * nearest.distance_m, GradientAt(*at, nearest, sign), false};
  sample.kink = within_reach > 1 && IsKink(p, sample, sign);
  return sample;
}

}  // namespace cwm::collision
