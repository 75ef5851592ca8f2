#include "collision/kernels/convex_pair.h"

#include <cmath>
#include <optional>

#include "collision/geometry/signed_distance.h"
#include "collision/kernels/closed_forms.h"
#include "collision/kernels/gjk.h"
#include "collision/kernels/penetration.h"

namespace cwm::collision {
namespace {

PairDistance Penetrating(const CoreDifference& difference) {
  const Penetration found = FindPenetration(difference);
  PairDistance answer{.distance_m = -found.depth_m,
                      .point_a = found.point_a,
                      .point_b = found.point_b,
                      .normal = found.normal};
  if (found.bound_m > kExactTolerance_m) {
    answer.accuracy = Accuracy::kBounded;
    answer.bound_m = found.bound_m;
  }
  return answer;
}

// The answer for separated cores: kBounded if GJK left more open than kExact allows, as it may for
// round cores of very different sizes.
PairDistance Separated(const GjkResult& gjk) {
  PairDistance answer{gjk.distance_m, gjk.point_a, gjk.point_b, gjk.normal};
  if (gjk.bound_m > kExactTolerance_m) {
    answer.accuracy = Accuracy::kBounded;
    answer.bound_m = gjk.bound_m;
  }
  return answer;
}

// The part of box A near B, which is as far from B as all of A but causes less rounding, since
// rounding grows with the larger shape. Clamping the coordinates of a point gives its nearest point
// in the box, so the part spanned by the clamped bounds of B is enough. Empty if A is not a box
// much larger than B.
struct BoxPart {
  ConvexCore core;
  Vector3 centre;  // in the frame of A
};
std::optional<BoxPart> NearbyBoxPart(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB) {
  constexpr double kMinSizeRatio = 8;  // chosen: at smaller ratios a part saves less than a digit
  const auto* box = std::get_if<Box>(&a.core);
  if (box == nullptr || a.extent_m <= kMinSizeRatio * b.extent_m || b.extent_m == 0) {
    return std::nullopt;
  }
  const Vector3 half = 0.5 * box->size_m;
  // The ball around B is a sufficient bound; twice its radius keeps the part from being flat.
  const Vector3 centre = X_AB * b.centre, reach = Vector3::Constant(2 * b.extent_m);
  const Vector3 low = (centre - reach).cwiseMax(-half).cwiseMin(half - reach.cwiseMin(half));
  const Vector3 high = (centre + reach).cwiseMin(half).cwiseMax(reach.cwiseMin(half) - half);
  return BoxPart{CoreOf(Shape(Box{high - low})), 0.5 * (low + high)};
}

// GJK on the part of each core that matters. If the parts touch, GJK on the whole cores decides.
GjkResult LocalGjkDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                           double max_distance_m) {
  const CoreDifference difference(a, b, X_AB);
  if (const auto part = NearbyBoxPart(a, b, X_AB)) {
    Pose X_PB = X_AB;
    X_PB.translation() -= part->centre;
    GjkResult answer = GjkDistance(CoreDifference(part->core, b, X_PB), max_distance_m);
    answer.point_a += part->centre;
    answer.point_b += part->centre;
    if (answer.outcome != GjkOutcome::kTouching) return answer;
  } else if (const auto part_b = NearbyBoxPart(b, a, X_AB.inverse(Eigen::Isometry))) {
    Pose X_AP = X_AB;
    X_AP.translation() += X_AB.linear() * part_b->centre;
    const GjkResult answer = GjkDistance(CoreDifference(a, part_b->core, X_AP), max_distance_m);
    if (answer.outcome != GjkOutcome::kTouching) return answer;
  }
  return GjkDistance(difference, max_distance_m);
}

SurfacePoint NearestOnCore(const ConvexCore& shape, const Vector3& p) {
  if (const auto* box = std::get_if<Box>(&shape.core)) return NearestSurfacePoint(*box, p);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape.core)) {
    return NearestSurfacePoint(*cylinder, p);
  }
  if (const auto* cone = std::get_if<Cone>(&shape.core)) return NearestSurfacePoint(*cone, p);
  const auto* segment = std::get_if<SegmentCore>(&shape.core);
  return NearestSurfacePoint(Capsule{0, segment != nullptr ? 2 * segment->half_length_m : 0}, p);
}

// The distance of core A and a point B, by the point of A's surface nearest to B.
PairDistance CoreToPoint(const ConvexCore& a, const Vector3& p) {
  const SurfacePoint at = NearestOnCore(a, p);
  return {at.signed_distance_m, p - at.signed_distance_m * at.normal, p, at.normal};
}

bool IsPoint(const ConvexCore& shape) { return std::holds_alternative<PointCore>(shape.core); }
bool HasVertices(const ConvexCore& s) { return std::holds_alternative<VertexCore>(s.core); }

// True if ConvexDistance has a formula for the pair. Two boxes are handled separately.
bool HasClosedForm(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB) {
  const auto is_segment = [](const ConvexCore& s) {
    return std::holds_alternative<SegmentCore>(s.core);
  };
  const auto is_box = [](const ConvexCore& s) { return std::holds_alternative<Box>(s.core); };
  if ((IsPoint(a) && !HasVertices(b)) || (IsPoint(b) && !HasVertices(a))) return true;
  if (is_segment(a) && (is_segment(b) || is_box(b))) return true;
  if (is_segment(b) && is_box(a)) return true;
  return IsRevolved(a) && IsRevolved(b) && AxesAreParallel(X_AB);
}

PairDistance BoxToBox(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                      double max_distance_m) {
  const BoxOverlap overlap = MinBoxOverlap(std::get<Box>(a.core), std::get<Box>(b.core), X_AB);
  if (-overlap.depth_m > max_distance_m) return BeyondLimit(-overlap.depth_m);
  const CoreDifference difference(a, b, X_AB);
  const GjkResult gjk = LocalGjkDistance(a, b, X_AB, max_distance_m);
  if (gjk.outcome == GjkOutcome::kBeyond) return BeyondLimit(gjk.distance_m);
  if (gjk.outcome == GjkOutcome::kSeparated) {
    return Separated(gjk);
  }
  PairDistance answer{.distance_m = -overlap.depth_m, .normal = overlap.normal};
  answer.point_a = WitnessOnA(difference, overlap.depth_m, overlap.normal);
  answer.point_b = answer.point_a - overlap.depth_m * overlap.normal;
  return answer;
}

}  // namespace

PairDistance Swapped(const PairDistance& answer) {
  PairDistance swapped = answer;
  swapped.point_a = answer.point_b;
  swapped.point_b = answer.point_a;
  swapped.normal = -answer.normal;
  return swapped;
}

PairDistance InFrame(const Pose& X_FA, const PairDistance& answer) {
  PairDistance moved = answer;
  moved.point_a = X_FA * answer.point_a;
  moved.point_b = X_FA * answer.point_b;
  moved.normal = X_FA.linear() * answer.normal;
  return moved;
}

PairDistance BeyondLimit(double lower_bound_m) { return {.distance_m = lower_bound_m}; }

PairDistance FartherThan(double max_distance_m) {
  return BeyondLimit(std::nextafter(max_distance_m, std::numeric_limits<double>::infinity()));
}

PairDistance IterativeConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                                     double max_distance_m) {
  const CoreDifference difference(a, b, X_AB);
  const double radii = a.radius_m + b.radius_m;
  const GjkResult gjk = LocalGjkDistance(a, b, X_AB, max_distance_m + radii);
  switch (gjk.outcome) {
    case GjkOutcome::kBeyond:
      return BeyondLimit(gjk.distance_m - radii);
    case GjkOutcome::kSeparated:
      return WithRadii(Separated(gjk), a.radius_m, b.radius_m);
    case GjkOutcome::kTouching:
      break;
  }
  return WithRadii(Penetrating(difference), a.radius_m, b.radius_m);
}

PairDistance ConvexDistance(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB,
                            double max_distance_m) {
  if (IsPoint(b) && !HasVertices(a)) {
    return WithRadii(CoreToPoint(a, X_AB.translation()), a.radius_m, b.radius_m);
  }
  const auto* box_a = std::get_if<Box>(&a.core);
  const auto* segment_a = std::get_if<SegmentCore>(&a.core);
  const auto* segment_b = std::get_if<SegmentCore>(&b.core);
  if (segment_a != nullptr && segment_b != nullptr) {
    return CapsuleToCapsule({a.radius_m, 2 * segment_a->half_length_m},
                            {b.radius_m, 2 * segment_b->half_length_m}, X_AB);
  }
  if (box_a != nullptr && segment_b != nullptr) {
    return BoxToCapsule(*box_a, {b.radius_m, 2 * segment_b->half_length_m}, X_AB);
  }
  if (box_a != nullptr && std::holds_alternative<Box>(b.core)) {
    return BoxToBox(a, b, X_AB, max_distance_m);
  }
  const bool b_needs_swap = (IsPoint(a) && !HasVertices(b)) ||
                            (segment_a != nullptr && std::holds_alternative<Box>(b.core));
  if (b_needs_swap) {
    return Swapped(InFrame(X_AB, ConvexDistance(b, a, X_AB.inverse(), max_distance_m)));
  }
  if (IsRevolved(a) && IsRevolved(b) && AxesAreParallel(X_AB))
    return ParallelRevolvedDistance(a, b, X_AB);
  return IterativeConvexDistance(a, b, X_AB, max_distance_m);
}

bool ConvexOverlap(const ConvexCore& a, const ConvexCore& b, const Pose& X_AB) {
  const double reach_m = a.extent_m + a.radius_m + b.extent_m + b.radius_m;
  if ((X_AB * b.centre - a.centre).squaredNorm() > reach_m * reach_m) return false;
  const auto *box_a = std::get_if<Box>(&a.core), *box_b = std::get_if<Box>(&b.core);
  if (box_a != nullptr && box_b != nullptr) return BoxesOverlap(*box_a, *box_b, X_AB);
  if (!HasClosedForm(a, b, X_AB)) {
    const CoreDifference difference(a, b, X_AB);
    if (const auto result = GjkOverlap(difference, a.radius_m + b.radius_m)) return *result;
  }
  return ConvexDistance(a, b, X_AB, 0).distance_m < 0;
}

}  // namespace cwm::collision
