#include "perception/vessels/shell_profile.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"
#include "perception/vessels/revolved_wall.h"

namespace cwm::perception {
namespace {

// chosen: rings on either side whose line gives a ring's radius and slope (30 mm of wall with the
// one between). The wall is extrapolated as far beyond the last ring.
constexpr int kReach_steps = 2;
// chosen: the inside of a vessel is deeper than its wall is thick.
constexpr double kMinInside_m = kWallThickness_m;
// chosen: the least sine of the slope of a bowl's inside; a flatter one is a floor.
constexpr double kMinSlant_sin = 0.2;

// Douglas and Peucker: keeps the corners that hold the line within the tolerance.
void Simplify(const std::vector<Vector2>& line, std::size_t begin, std::size_t end,
              double tolerance_m, std::vector<Vector2>& out) {
  const Vector2 chord = line[end] - line[begin];
  double worst_m = 0;
  std::size_t worst = begin;
  for (std::size_t k = begin + 1; k < end; ++k) {
    const Vector2 at = line[k] - line[begin];
    const double way =
        chord.squaredNorm() > 0 ? std::clamp(at.dot(chord) / chord.squaredNorm(), 0.0, 1.0) : 0;
    const double off_m = (at - way * chord).norm();
    if (off_m > worst_m) worst_m = off_m, worst = k;
  }
  if (worst_m <= tolerance_m) {
    out.push_back(line[end]);
    return;
  }
  Simplify(line, begin, worst, tolerance_m, out);
  Simplify(line, worst, end, tolerance_m, out);
}

std::vector<Vector2> Simplified(const std::vector<Vector2>& line) {
  std::vector<Vector2> out = {line.front()};
  if (line.size() > 1) Simplify(line, 0, line.size() - 1, kSubNoise_m, out);
  return out;
}

// The horizontal thickness of a slanted wall.
double Level_m(double thickness_m, double slope) {
  return thickness_m * std::sqrt(1 + slope * slope);
}

class ProfileMaker {
 public:
  explicit ProfileMaker(const ShellOutline& outline) : o_(outline) {
    const double lowest_floor_m = LowestFloor_m();
    foot_m_ = std::min(o_.rings.front().z_m, lowest_floor_m - o_.thickness_m);
    if (o_.ground_z_m) {
      const bool stands =
          o_.foot == ShellFoot::kOnGround || foot_m_ - *o_.ground_z_m < kStandingGap_m;
      if (stands) foot_m_ = *o_.ground_z_m;
      foot_m_ = std::max(foot_m_, *o_.ground_z_m);
    }
    floor_m_ = o_.floor.empty() ? foot_m_ + o_.thickness_m
                                : std::max(lowest_floor_m, foot_m_ + kMinVesselWall_m);
  }

  std::optional<ShellProfile> Make() const {
    if (!(o_.rim_z_m - floor_m_ > kMinInside_m)) return std::nullopt;
    std::vector<Vector2> outer = Outer(), inner = Inner();
    const double middle_m = 0.5 * (foot_m_ + o_.rim_z_m);
    ShellProfile made{.shell = {}, .middle_z_m = middle_m};
    made.measured_share = MeasuredArea() / (AreaOf(outer) + AreaOf(inner));
    for (Vector2& point : outer) point.y() -= middle_m;
    for (Vector2& point : inner) point.y() -= middle_m;
    made.shell.outer = Simplified(outer);
    made.shell.inner = Simplified(inner);
    made.shell.wall_thickness_m = o_.thickness_m;
    return made;
  }

 private:
  double LowestFloor_m() const {
    double lowest_m = std::numeric_limits<double>::infinity();
    for (const Vector2& place : o_.floor) lowest_m = std::min(lowest_m, place.y());
    return lowest_m;
  }

  // The wall at a height, interpolated between rings, and straight down below them.
  WallRing WallAt(double z_m) const {
    const std::vector<WallRing>& rings = o_.rings;
    if (z_m <= rings.front().z_m) {
      return {.z_m = z_m, .radius_m = rings.front().radius_m};
    }
    const auto above = std::find_if(rings.begin(), rings.end(),
                                    [&](const WallRing& ring) { return ring.z_m >= z_m; });
    if (above == rings.end()) {
      const WallRing& last = rings.back();
      const double rise_m = std::min(z_m - last.z_m, kReach_steps * o_.step_m);
      const double min_m = kMinThickness_m + Level_m(o_.thickness_m, last.slope);
      return {.z_m = z_m,
              .radius_m = std::max(min_m, last.radius_m + rise_m * last.slope),
              .slope = last.slope};
    }
    const auto below = above - 1;
    const double share = (z_m - below->z_m) / (above->z_m - below->z_m);
    return {.z_m = z_m,
            .radius_m = std::lerp(below->radius_m, above->radius_m, share),
            .slope = std::lerp(below->slope, above->slope, share)};
  }

  // The wall from a height up to the rim, both included.
  std::vector<WallRing> WallFrom(double z_m) const {
    std::vector<WallRing> wall = {WallAt(z_m)};
    for (const WallRing& ring : o_.rings) {
      if (ring.z_m > z_m && ring.z_m < o_.rim_z_m) wall.push_back(ring);
    }
    wall.push_back(WallAt(o_.rim_z_m));
    return wall;
  }

  // The height at which the floor meets the wall.
  double WallsFoot_m() const {
    return o_.floor.empty() ? floor_m_ : std::max(floor_m_, o_.floor.front().y());
  }

  std::vector<Vector2> Inner() const {
    std::vector<WallRing> wall = WallFrom(std::min(WallsFoot_m(), o_.rim_z_m - kMinInside_m));
    std::vector<Vector2> inner;
    for (auto ring = wall.rbegin(); ring != wall.rend(); ++ring) {
      inner.emplace_back(
          std::max(kMinThickness_m, ring->radius_m - Level_m(o_.thickness_m, ring->slope)),
          ring->z_m);
    }
    for (const Vector2& place : o_.floor) {
      if (place.x() < inner.back().x())
        inner.emplace_back(place.x(), std::max(floor_m_, place.y()));
    }
    inner.emplace_back(0, o_.floor.empty() ? floor_m_ : inner.back().y());
    return inner;
  }

  // The outside profile. Below its wall a bowl's outside narrows as its inside does, except at the
  // foot.
  std::vector<Vector2> Outer() const {
    std::vector<Vector2> under;  // downwards
    const WallRing& lowest = o_.rings.front();
    Vector2 before(lowest.radius_m - Level_m(o_.thickness_m, lowest.slope), lowest.z_m);
    for (const Vector2& place : o_.floor) {
      const Vector2 along = (place - before).normalized();
      const Vector2 below =
          0.5 * (before + place) + o_.thickness_m * Vector2(-along.y(), along.x());
      before = place;
      const double last_m = under.empty() ? lowest.radius_m : under.back().x();
      const double last_z_m = under.empty() ? lowest.z_m : under.back().y();
      if (along.y() > -kMinSlant_sin || below.y() < floor_m_) break;
      if (below.y() > last_z_m || below.x() > last_m) continue;
      under.push_back(below);
    }
    std::vector<Vector2> outer;
    const double foot_radius_m = under.empty() ? WallAt(foot_m_).radius_m : under.back().x();
    outer.emplace_back(foot_radius_m, foot_m_);
    for (auto place = under.rbegin(); place != under.rend(); ++place) outer.push_back(*place);
    for (const WallRing& ring : WallFrom(under.empty() ? foot_m_ : lowest.z_m)) {
      if (ring.z_m > outer.back().y()) outer.emplace_back(ring.radius_m, ring.z_m);
    }
    return outer;
  }

  // The area of a surface of revolution, divided by 2 pi.
  static double AreaOf(const std::vector<Vector2>& line) {
    double area = 0;
    for (std::size_t k = 0; k + 1 < line.size(); ++k) {
      area += 0.5 * (line[k].x() + line[k + 1].x()) * (line[k + 1] - line[k]).norm();
    }
    return area;
  }
  double MeasuredArea() const {
    double area = 0;
    for (const WallRing& ring : o_.rings) {
      const double one_side = ring.radius_m * Level_m(o_.step_m, ring.slope);
      area += (ring.shows_outside ? one_side : 0) + (ring.shows_inside ? one_side : 0);
    }
    for (const Vector2& place : o_.floor) area += place.x() * o_.step_m;
    return area;
  }

  const ShellOutline& o_;
  double foot_m_ = 0, floor_m_ = 0;  // heights of the foot and of the deepest place inside
};

}  // namespace

std::vector<WallRing> Smoothed(const std::vector<WallRing>& rings, double step_m) {
  std::vector<WallRing> smoothed = rings;
  for (WallRing& ring : smoothed) {
    double w = 0, z = 0, r = 0, zz = 0, zr = 0;
    for (const WallRing& near : rings) {
      const double at_m = near.z_m - ring.z_m;
      if (std::lround(std::abs(at_m) / step_m) > kReach_steps) continue;
      w += near.weight, z += near.weight * at_m, r += near.weight * near.radius_m;
      zz += near.weight * at_m * at_m, zr += near.weight * at_m * near.radius_m;
    }
    const double spread = w * zz - z * z;
    if (spread > 0.25 * w * w * step_m * step_m) {
      ring.slope = (w * zr - z * r) / spread;
      ring.radius_m = (r - ring.slope * z) / w;
    }
  }
  return smoothed;
}

std::optional<ShellProfile> MakeShell(const ShellOutline& outline) {
  return ProfileMaker(outline).Make();
}

}  // namespace cwm::perception
