#include <cmath>
#include <limits>

#include "collision/kernels/closed_forms.h"

namespace cwm::collision {
namespace {

// Edges at a smaller sine count as parallel: the axis of a face then separates the boxes as well,
// up to this share of their size.
constexpr double kParallelSine = 1e-11;

// Share of the size by which a later axis must beat the earlier ones, so that rounding cannot
// change the normal of face contacts.
constexpr double kFacePreference = 1e-13;

class SeparatingAxisTest {
 public:
  SeparatingAxisTest(const Box& a, const Box& b, const Pose& X_AB)
      : half_a_(0.5 * a.size_m),
        half_b_(0.5 * b.size_m),
        R_AB_(X_AB.linear()),
        p_AB_(X_AB.translation()),
        size_(half_a_.maxCoeff() + half_b_.maxCoeff()) {}

  // The least overlap found. Stops after the first depth that is not above `enough_m`.
  BoxOverlap Run(double enough_m) {
    for (int i = 0; i < 3 && best_.depth_m > enough_m; ++i) {
      Consider(Vector3::Unit(i), 0);
      Consider(R_AB_.col(i), kFacePreference * size_);
    }
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3 && best_.depth_m > enough_m; ++j) {
        const Vector3 axis = Vector3::Unit(i).cross(R_AB_.col(j));
        const double sine = axis.norm();
        if (sine > kParallelSine) Consider(axis / sine, kFacePreference * size_);
      }
    }
    return best_;
  }

 private:
  void Consider(const Vector3& axis, double handicap) {
    const double reach =
        half_a_.dot(axis.cwiseAbs()) + half_b_.dot((R_AB_.transpose() * axis).cwiseAbs());
    const double offset = axis.dot(p_AB_);
    const double depth = reach - std::abs(offset);
    if (!(depth < best_.depth_m - handicap)) return;
    best_ = {depth, offset < 0 ? Vector3(-axis) : axis};
  }

  const Vector3 half_a_, half_b_;
  const Matrix3 R_AB_;
  const Vector3 p_AB_;
  const double size_;
  BoxOverlap best_{std::numeric_limits<double>::infinity(), Vector3::UnitZ()};
};

}  // namespace

BoxOverlap MinBoxOverlap(const Box& a, const Box& b, const Pose& X_AB) {
  return SeparatingAxisTest(a, b, X_AB).Run(-std::numeric_limits<double>::infinity());
}

bool BoxesOverlap(const Box& a, const Box& b, const Pose& X_AB) {
  return SeparatingAxisTest(a, b, X_AB).Run(0).depth_m > 0;
}

}  // namespace cwm::collision
