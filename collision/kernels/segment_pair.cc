#include "collision/kernels/segment_pair.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collision/geometry/segment.h"

namespace cwm::collision {
namespace {

// Share of the extent. Points nearer than this define no direction (see kTouchingRatio in gjk.h;
// here the formulas keep more digits).
constexpr double kMeetingShare = 1e-13;

// chosen: share of the gap by which a plane across it must separate the two. If it does not,
// rounding has destroyed the direction.
constexpr double kMinCertifiedShare = 0.9;

struct NearestPair {
  Vector3 on_a, on_b;
  bool is_crossing = false;  // both lie inside their segments, on the common perpendicular
  double squared() const { return (on_b - on_a).squaredNorm(); }
};

// The nearest points of two segments: the feet of the common perpendicular if both lie inside, else
// an end point and its nearest point. All candidates are compared, so that nearly parallel segments
// lose no digits.
NearestPair NearestPoints(const Segment& a, const Segment& b) {
  std::array<NearestPair, 5> candidates = {NearestPair{a.a, NearestOnSegment(b.a, b.b, a.a)},
                                           NearestPair{a.b, NearestOnSegment(b.a, b.b, a.b)},
                                           NearestPair{NearestOnSegment(a.a, a.b, b.a), b.a},
                                           NearestPair{NearestOnSegment(a.a, a.b, b.b), b.b}};
  const Vector3 u = a.b - a.a, v = b.b - b.a, w = b.a - a.a;
  const Vector3 n = u.cross(v);
  const double nn = n.squaredNorm();
  std::size_t count = 4;
  if (nn > 0) {
    const double s = w.cross(v).dot(n) / nn, t = w.cross(u).dot(n) / nn;
    if (s > 0 && s < 1 && t > 0 && t < 1) {
      // In nearly parallel segments, rounding moves each foot independently by 1e-16 divided by the
      // angle. Each is therefore computed as the nearest point to the other.
      const Vector3 on_b = NearestOnSegment(b.a, b.b, Vector3(a.a + s * u));
      candidates[count++] = {NearestOnSegment(a.a, a.b, on_b), on_b, true};
    }
  }
  return *std::min_element(
      candidates.begin(), candidates.begin() + static_cast<std::ptrdiff_t>(count),
      [](const NearestPair& x, const NearestPair& y) { return x.squared() < y.squared(); });
}

// A unit direction that is perpendicular to two crossing segments, pointing towards the middle of
// B.
Vector3 ParticularNormal(const Segment& a, const Segment& b) {
  const Vector3 u = a.b - a.a, v = b.b - b.a;
  Vector3 n = u.cross(v);
  if (n.norm() <= kMeetingShare * u.norm() * v.norm()) {
    const Vector3& longer = u.norm() > v.norm() ? u : v;
    return longer.norm() > 0 ? Vector3(BasisFromZ(longer.normalized()).col(0)) : Vector3::UnitZ();
  }
  n.normalize();
  return n.dot(b.a + b.b - a.a - a.b) < 0 ? Vector3(-n) : n;
}

// The gap between A and B along `n`; negative if their projections overlap.
double GapAlong(const Segment& a, const Segment& b, const Vector3& n) {
  return std::min(n.dot(b.a), n.dot(b.b)) - std::max(n.dot(a.a), n.dot(a.b));
}

Vector3 Clamp(const Vector3& p, const Vector3& half) { return p.cwiseMax(-half).cwiseMin(half); }

// The same for a box and a segment.
double GapAlong(const Vector3& half, const Segment& segment, const Vector3& n) {
  return std::min(n.dot(segment.a), n.dot(segment.b)) - half.dot(n.cwiseAbs());
}

// Half the derivative of the squared distance to the box along a segment. Never decreases with t.
double Slope(const Vector3& half, const Segment& segment, double t) {
  const Vector3 along = segment.b - segment.a, p = segment.a + t * along;
  return (p - Clamp(p, half)).dot(along);
}

// The parameter t of the segment's point nearest to the box, where Slope changes sign. Slope is
// linear between the parameters at which the segment crosses the planes of the faces.
double NearestParameter(const Vector3& half, const Segment& segment) {
  const Vector3 along = segment.b - segment.a;
  double low = 0, high = 1;
  if (Slope(half, segment, low) >= 0) return low;
  if (Slope(half, segment, high) <= 0) return high;
  for (int axis = 0; axis < 3; ++axis) {
    if (along[axis] == 0) continue;
    for (const double face : {-half[axis], half[axis]}) {
      const double t = (face - segment.a[axis]) / along[axis];
      if (!(t > low && t < high)) continue;
      (Slope(half, segment, t) < 0 ? low : high) = t;
    }
  }
  const double at_low = Slope(half, segment, low), at_high = Slope(half, segment, high);
  if (!(at_high > at_low)) return low;
  return std::clamp(low - at_low * (high - low) / (at_high - at_low), low, high);
}

// The minimum translation of a segment out of a box that it enters. The faces of their Minkowski
// difference are those of the box and those spanned by a box edge and the segment.
PairDistance SegmentInBox(const Vector3& half, const Segment& segment) {
  const Vector3 along = segment.b - segment.a, middle = 0.5 * (segment.a + segment.b);
  const double length = along.norm();
  PairDistance best{.distance_m = -std::numeric_limits<double>::infinity()};
  const auto consider = [&](const Vector3& axis, double handicap) {
    const Vector3 n = axis.dot(middle) < 0 ? Vector3(-axis) : axis;
    const double reach = half.dot(n.cwiseAbs()) + 0.5 * std::abs(along.dot(n));
    const double distance = n.dot(middle) - reach;
    if (distance <= best.distance_m + handicap) return;
    best.distance_m = distance;
    best.normal = n;
  };
  for (int i = 0; i < 3; ++i) consider(Vector3::Unit(i), 0);
  for (int i = 0; i < 3; ++i) {
    const Vector3 axis = along.cross(Vector3::Unit(i));
    if (axis.norm() <= kMeetingShare * length || !(length > 0)) continue;
    // A face is preferred to an edge of equal depth.
    consider(axis.normalized(), kMeetingShare * half.maxCoeff());
  }
  // After moving the segment by more than the depth, the nearest points are those that touch last.
  const double gap = half.maxCoeff();
  const Vector3 shift = (gap - best.distance_m) * best.normal;
  const Segment parted{segment.a + shift, segment.b + shift};
  const double place = NearestParameter(half, parted);
  best.point_a = Clamp(parted.a + place * (parted.b - parted.a), half);
  best.point_b = best.point_a + best.distance_m * best.normal;
  return best;
}

}  // namespace

PairDistance SegmentToSegment(const Segment& a, const Segment& b) {
  const NearestPair nearest = NearestPoints(a, b);
  const double size = (a.b - a.a).norm() + (b.b - b.a).norm();
  const double distance = std::sqrt(nearest.squared());
  PairDistance answer{.point_a = nearest.on_a, .point_b = nearest.on_b};
  if (distance > kMeetingShare * size) {
    answer.distance_m = distance;
    answer.normal = (nearest.on_b - nearest.on_a) / distance;
    if (nearest.is_crossing) {
      // The common perpendicular is accurate even if the gap is too small to define a direction.
      const Vector3 n = (a.b - a.a).cross(b.b - b.a).normalized();
      answer.normal = n.dot(answer.normal) < 0 ? Vector3(-n) : n;
    }
    if (GapAlong(a, b, answer.normal) < kMinCertifiedShare * distance) {
      answer.normal = ParticularNormal(a, b);
      answer.point_b = answer.point_a + distance * answer.normal;
    }
  } else {
    answer.normal = ParticularNormal(a, b);
    answer.point_b = answer.point_a;
  }
  return answer;
}

PairDistance BoxToSegment(const Box& box, const Segment& segment) {
  const Vector3 half = 0.5 * box.size_m;
  const double place = NearestParameter(half, segment);
  const Vector3 on_segment = segment.a + place * (segment.b - segment.a);
  const Vector3 on_box = Clamp(on_segment, half);
  const double distance = (on_segment - on_box).norm();
  if (distance > kMeetingShare * half.maxCoeff()) {
    const Vector3 normal = (on_segment - on_box) / distance;
    if (GapAlong(half, segment, normal) >= kMinCertifiedShare * distance) {
      return {distance, on_box, on_segment, normal};
    }
  }
  return SegmentInBox(half, segment);
}

}  // namespace cwm::collision
