#include "perception/refinement/merge/tray.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/fit/solid.h"
#include "perception/refinement/evidence.h"
#include "perception/solids/plane_solid.h"

namespace cwm::perception {
namespace {

constexpr double kMinWall_m = 0.03;  // chosen: the least length of a side

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void Extend(double x) { low = std::min(low, x), high = std::max(high, x); }
  double length() const { return high - low; }
  double middle() const { return 0.5 * (low + high); }
};

Span SpanAlong(const LoneWall& wall, const Vector2& direction) {
  Span span;
  for (const Vector2& end : wall.ends) span.Extend(end.dot(direction));
  return span;
}

bool AreParallel(const Vector2& a, const Vector2& b) {
  return std::abs(a.dot(b)) >= std::cos(kSameDirection_rad);
}
bool AreOrthogonal(const Vector2& a, const Vector2& b) {
  return std::abs(a.dot(b)) <= std::sin(kSameDirection_rad);
}

// A wall, or several that others divide.
struct Candidate {
  LoneWall wall;
  std::vector<std::size_t> of;  // indices of given walls
};

bool CarryOn(const LoneWall& a, const LoneWall& b) {
  return a.normal.dot(b.normal) >= std::cos(kSameDirection_rad) &&
         std::abs(a.rim_m - b.rim_m) <= kVesselRim_m &&
         std::abs(SpanAlong(a, a.normal).middle() - SpanAlong(b, a.normal).middle()) <=
             kMaxSameFaceGap_m;
}

// All walls, and the complete wall of each set of collinear pieces.
std::vector<Candidate> WithWholeWalls(const std::vector<LoneWall>& walls) {
  std::vector<Candidate> all, wholes;
  for (std::size_t a = 0; a < walls.size(); ++a) {
    all.push_back({walls[a], {a}});
    const Vector2 along(-walls[a].normal.y(), walls[a].normal.x());
    Candidate whole{walls[a], {}};
    Span span;
    for (std::size_t b = 0; b < walls.size(); ++b) {
      if (!CarryOn(walls[a], walls[b])) continue;
      whole.of.push_back(b);
      for (const Vector2& end : walls[b].ends) span.Extend(end.dot(along));
    }
    const bool is_known =
        std::ranges::any_of(wholes, [&](const Candidate& other) { return other.of == whole.of; });
    if (whole.of.size() < 2 || is_known || span.length() > kMaxObjectSize_m) continue;
    const Vector2 foot = SpanAlong(walls[a], walls[a].normal).middle() * walls[a].normal;
    whole.wall.ends = {foot + span.low * along, foot + span.high * along};
    wholes.push_back(std::move(whole));
  }
  all.insert(all.end(), wholes.begin(), wholes.end());
  return all;
}

// True if the two may be opposite sides; two outsides cannot be seen at once.
bool AreOpposite(const LoneWall& a, const LoneWall& b) {
  if (!AreParallel(a.normal, b.normal) || std::abs(a.rim_m - b.rim_m) > kVesselRim_m) return false;
  const Vector2 along(-a.normal.y(), a.normal.x());
  const double from_m = SpanAlong(a, a.normal).middle(), to_m = SpanAlong(b, a.normal).middle();
  const double apart_m = std::abs(to_m - from_m);
  if (apart_m < kMinWall_m || apart_m > kMaxObjectSize_m) return false;
  if (a.normal.dot(b.normal) < 0 && to_m < from_m) return false;
  const Span of_a = SpanAlong(a, along), of_b = SpanAlong(b, along);
  const double common_m = std::min(of_a.high, of_b.high) - std::max(of_a.low, of_b.low);
  const double shorter_m = std::min(of_a.length(), of_b.length());
  return common_m >= kMainShare * shorter_m &&
         shorter_m >= kMinInSight * std::max(of_a.length(), of_b.length());
}

Tray BoxOf(const std::vector<Candidate>& walls, const Candidate& a, const Candidate& b,
           const Vector3& sensor_P) {
  const Vector2 x = a.wall.normal, y(-x.y(), x.x());
  Tray box;
  box.rim_m = 0.5 * (a.wall.rim_m + b.wall.rim_m);
  Span across, along;
  for (const Candidate* side : {&a, &b}) {
    across.Extend(SpanAlong(side->wall, x).middle());
    along.Extend(SpanAlong(side->wall, y).low);
    along.Extend(SpanAlong(side->wall, y).high);
  }
  for (Tray::Side& side : box.sides) side.rim_m = box.rim_m;
  const auto see = [&](std::size_t side, const Candidate& seen) {
    box.sides[side].is_seen = true;
    box.sides[side].in_pieces = seen.of.size() > 1;
    box.sides[side].rim_m = seen.wall.rim_m;
    box.walls.insert(box.walls.end(), seen.of.begin(), seen.of.end());
    box.seen_m += SpanAlong(seen.wall, {-seen.wall.normal.y(), seen.wall.normal.x()}).length();
  };
  const bool a_is_high = SpanAlong(a.wall, x).middle() > across.middle();
  see(a_is_high ? 0 : 1, a);
  see(a_is_high ? 1 : 0, b);
  const Span ends = along;
  for (std::size_t end = 0; end < 2; ++end) {
    const double end_m = end == 0 ? ends.high : ends.low;
    const Candidate* longest = nullptr;
    double length_m = kMinInSight * across.length();
    for (const Candidate& candidate : walls) {
      const LoneWall& wall = candidate.wall;
      if (!AreOrthogonal(wall.normal, x) || std::abs(wall.rim_m - box.rim_m) > kVesselRim_m)
        continue;
      const Span between = SpanAlong(wall, x);
      if (between.low < across.low - kEdgeLoss_m || between.high > across.high + kEdgeLoss_m)
        continue;
      if (std::abs(SpanAlong(wall, y).middle() - end_m) > kEdgeLoss_m) continue;
      if (between.length() > length_m) longest = &candidate, length_m = between.length();
    }
    if (longest == nullptr) continue;
    (end == 0 ? along.high : along.low) = SpanAlong(longest->wall, y).middle();
    see(2 + end, *longest);
  }
  box.size_m = Vector2(across.length(), along.length());
  const Vector2 middle = across.middle() * x + along.middle() * y;
  box.X_PB.linear() << x.x(), y.x(), 0, x.y(), y.y(), 0, 0, 0, 1;
  box.X_PB.translation() << middle, 0;
  const Vector3 sensor_B = box.X_PB.inverse(Eigen::Isometry) * sensor_P;
  for (std::size_t k = 0; k < box.sides.size(); ++k) {
    const auto axis = static_cast<Eigen::Index>(k / 2);
    const double outward = k % 2 == 0 ? sensor_B(axis) : -sensor_B(axis);
    box.sides[k].from_outside = outward > 0.5 * box.size_m(axis);
  }
  return box;
}

// True if a wall of the same height stands between two of the sides.
bool IsDivided(const Tray& box, const std::vector<Candidate>& walls) {
  const Pose X_BP = box.X_PB.inverse(Eigen::Isometry);
  return std::ranges::any_of(walls, [&](const Candidate& candidate) {
    const LoneWall& wall = candidate.wall;
    if (std::abs(wall.rim_m - box.rim_m) > kVesselRim_m) return false;
    const Vector2 normal = (X_BP.linear() * Vector3(wall.normal.x(), wall.normal.y(), 0)).head<2>();
    Span at[2];
    for (const Vector2& end : wall.ends) {
      const Vector3 p = X_BP * Vector3(end.x(), end.y(), 0);
      for (Eigen::Index k = 0; k < 2; ++k) at[k].Extend(p(k));
    }
    for (Eigen::Index k = 0; k < 2; ++k) {
      if (!AreParallel(normal, Vector2::Unit(k))) continue;
      const Vector2 half = 0.5 * box.size_m;
      const double common_m =
          std::min(at[1 - k].high, half(1 - k)) - std::max(at[1 - k].low, -half(1 - k));
      return std::abs(at[k].middle()) < half(k) - kEdgeLoss_m &&
             common_m >= kMajority * box.size_m(1 - k);
    }
    return false;
  });
}

ShapePart BoxBetween(const Pose& X_PB, const Vector3& low, const Vector3& high, PartOrigin made) {
  ShapePart part;
  part.X_OS = X_PB;
  part.X_OS.translate(0.5 * (low + high));
  part.shape = Box{.size_m = high - low};
  part.role = made == PartOrigin::kMeasured ? PartRole::kFitted : PartRole::kCompleted;
  part.fit = FitQuality();
  return part;
}

}  // namespace

std::size_t Tray::seen_sides() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(sides, [](const Side& side) { return side.is_seen; }));
}

double Tray::ToSides_m(const Vector3& p_B) const {
  const Vector2 inside_m = 0.5 * size_m - p_B.head<2>().cwiseAbs();
  const double nearest_m = inside_m.minCoeff();
  return nearest_m >= 0 ? nearest_m : (-inside_m).cwiseMax(0).norm();
}

bool Tray::IsOver(const Vector3& p_B) const {
  return (p_B.head<2>().cwiseAbs().array() <= 0.5 * size_m.array()).all();
}

std::vector<Tray> FindTrays(const std::vector<LoneWall>& walls, const Vector3& sensor_P) {
  const std::vector<Candidate> all = WithWholeWalls(walls);
  std::vector<Tray> boxes;
  for (std::size_t a = 0; a < all.size(); ++a) {
    for (std::size_t b = a + 1; b < all.size(); ++b) {
      if (!AreOpposite(all[a].wall, all[b].wall)) continue;
      Tray box = BoxOf(all, all[a], all[b], sensor_P);
      if (!IsDivided(box, all)) boxes.push_back(std::move(box));
    }
  }
  std::ranges::stable_sort(boxes, [](const Tray& a, const Tray& b) {
    if (a.seen_sides() != b.seen_sides()) return a.seen_sides() > b.seen_sides();
    return a.seen_m > b.seen_m;
  });
  return boxes;
}

std::optional<LoneWall> AsLoneWall(const ShapePart& part, const Pose& X_PO,
                                   const Vector3& sensor_P) {
  const Pose X_PS = X_PO * part.X_OS;
  Eigen::Index thin = 2;
  double behind_m = 0;  // of the shape's middle behind the face
  std::vector<Vector3> corners;
  if (const auto* box = std::get_if<Box>(&part.shape)) {
    if (box->size_m.minCoeff(&thin) > kMaxLoneThickness_m) return std::nullopt;
    behind_m = 0.5 * box->size_m(thin);
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 sign((corner & 1) ? 1 : -1, (corner & 2) ? 1 : -1, (corner & 4) ? 1 : -1);
      corners.push_back(X_PS * (0.5 * sign.cwiseProduct(box->size_m)));
    }
  } else if (const auto* plate = std::get_if<Plate>(&part.shape)) {
    if (plate->thickness_m > kMaxLoneThickness_m) return std::nullopt;
    for (const Vector2& p : plate->outline) corners.push_back(X_PS * Vector3(p.x(), p.y(), 0));
  }
  if (corners.empty()) return std::nullopt;
  Vector3 normal = X_PS.linear().col(thin);
  // Sides of trays slope, and the normal of a side of two centimetres is hardly more certain with
  // noise.
  if (std::abs(normal.z()) > kWallRise_sin) return std::nullopt;
  if (normal.dot(sensor_P - X_PS.translation()) < 0) normal = -normal;
  LoneWall wall;
  wall.normal = normal.head<2>().normalized();
  const Vector2 along(-wall.normal.y(), wall.normal.x());
  const double at_m = wall.normal.dot(X_PS.translation().head<2>()) + behind_m;
  Span span, height;
  for (const Vector3& corner : corners) {
    span.Extend(along.dot(corner.head<2>()));
    height.Extend(corner.z());
  }
  if (span.length() < kMinWall_m || span.length() > kMaxObjectSize_m) return std::nullopt;
  wall.ends = {at_m * wall.normal + span.low * along, at_m * wall.normal + span.high * along};
  wall.rim_m = height.high;
  return wall;
}

std::vector<ShapePart> PartsOf(const Tray& box, const std::array<PartOrigin, 4>& sides,
                               double floor_m, PartOrigin floor) {
  // The outer surfaces of all sides.
  Vector3 low, high;
  low << -0.5 * box.size_m, 0;
  high << 0.5 * box.size_m, 0;
  for (Eigen::Index axis = 0; axis < 2; ++axis) {
    const auto k = static_cast<std::size_t>(2 * axis);
    if (!box.sides[k].from_outside) high(axis) += kLoneThickness_m;
    if (!box.sides[k + 1].from_outside) low(axis) -= kLoneThickness_m;
  }
  std::vector<ShapePart> parts;
  for (std::size_t k = 0; k < sides.size(); ++k) {
    if (sides[k] == PartOrigin::kNone) continue;
    const auto axis = static_cast<Eigen::Index>(k / 2);
    Vector3 from = low, to = high;
    to.z() = box.sides[k].rim_m;
    (k % 2 == 0 ? from : to)(axis) =
        k % 2 == 0 ? high(axis) - kLoneThickness_m : low(axis) + kLoneThickness_m;
    parts.push_back(BoxBetween(box.X_PB, from, to, sides[k]));
  }
  if (floor == PartOrigin::kNone) return parts;
  high.z() = std::max(floor_m, kMinThickness_m);
  parts.push_back(BoxBetween(box.X_PB, low, high, floor));
  return parts;
}

}  // namespace cwm::perception
