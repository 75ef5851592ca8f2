#include "collision/spheres/revolute_pair.h"

#include <cmath>

namespace cwm::collision {

RevolutePair::RevolutePair(const RevoluteJoint& near, const RevoluteJoint& far)
    : lower_rad_(near.lower_rad),
      upper_rad_(near.upper_rad),
      X_NA_(near.X_PF.inverse()),
      X_FN_(far.X_PF.inverse()) {}

// The far joint moves p_B on a circle. In its frame, the near joint moves p_A on another circle, at
// most by its radius per radian. The near joint may therefore turn until p_A has travelled its
// distance from the first circle, less `distance_m`, before the next check.
bool RevolutePair::KeepsApart(const Vector3& p_A, const Vector3& p_B, double distance_m) const {
  constexpr double kMinStep_m = 1e-3;  // chosen: gives a few hundred steps at most
  const Vector3 p_N = X_NA_ * p_A;
  const double radius_A_m = std::hypot(p_N.x(), p_N.y());
  const double radius_B_m = std::hypot(p_B.x(), p_B.y());
  for (double turn_rad = lower_rad_;;) {
    const double sine = std::sin(turn_rad), cosine = std::cos(turn_rad);
    const Vector3 p_F = X_FN_ * Vector3(cosine * p_N.x() + sine * p_N.y(),
                                        cosine * p_N.y() - sine * p_N.x(), p_N.z());
    const double across_m = std::sqrt(p_F.x() * p_F.x() + p_F.y() * p_F.y()) - radius_B_m;
    const double along_m = p_F.z() - p_B.z();
    const double step_m = std::sqrt(across_m * across_m + along_m * along_m) - distance_m;
    if (!(step_m > kMinStep_m)) return false;
    if (radius_A_m * (upper_rad_ - turn_rad) <= step_m) return true;
    turn_rad += step_m / radius_A_m;
  }
}

}  // namespace cwm::collision
