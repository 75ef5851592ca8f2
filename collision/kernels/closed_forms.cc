#include "collision/kernels/closed_forms.h"

#include <cmath>

#include "collision/kernels/segment_pair.h"

namespace cwm::collision {

PairDistance WithRadii(const PairDistance& cores, double radius_a_m, double radius_b_m) {
  PairDistance answer = cores;
  answer.distance_m -= radius_a_m + radius_b_m;
  answer.point_a += radius_a_m * cores.normal;
  answer.point_b -= radius_b_m * cores.normal;
  return answer;
}

PairDistance HalfSpaceToConvex(const ConvexCore& b, const Pose& X_AB) {
  const Vector3 down_B = -(X_AB.linear().row(2).transpose());
  const Vector3 lowest = X_AB * SupportPoint(b, down_B);
  const PairDistance core{.distance_m = lowest.z(),
                          .point_a = Vector3(lowest.x(), lowest.y(), 0),
                          .point_b = lowest,
                          .normal = Vector3::UnitZ()};
  return WithRadii(core, 0, b.radius_m);
}

PairDistance CapsuleToCapsule(const Capsule& a, const Capsule& b, const Pose& X_AB) {
  const Vector3 half_a(0, 0, 0.5 * a.length_m);
  const Vector3 half_b = 0.5 * b.length_m * X_AB.linear().col(2);
  const Segment core_a{-half_a, half_a};
  const Segment core_b{X_AB.translation() - half_b, X_AB.translation() + half_b};
  return WithRadii(SegmentToSegment(core_a, core_b), a.radius_m, b.radius_m);
}

PairDistance BoxToCapsule(const Box& a, const Capsule& b, const Pose& X_AB) {
  const Vector3 half_b = 0.5 * b.length_m * X_AB.linear().col(2);
  const Segment core_b{X_AB.translation() - half_b, X_AB.translation() + half_b};
  return WithRadii(BoxToSegment(a, core_b), 0, b.radius_m);
}

}  // namespace cwm::collision
