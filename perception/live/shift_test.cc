#include "perception/live/shift_test.h"

#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

// derived: with this slack and threshold a shift of two standard deviations is told after 8 frames,
// one of three after 4 (Siegmund 1985, "Sequential analysis"); one false alarm in 10^7 tests.
constexpr double kSlack = 1;
constexpr double kThreshold = 8;
// chosen: the assumed spread counts as much as this many measured frames.
constexpr double kAssumedFrames = 15;
// chosen: the mean follows slow drift, as of a sensor that warms up, within ten seconds at 30 Hz.
constexpr double kMemory_frames = 300;
// chosen: spreads below a fifth of a millimetre are luck.
constexpr double kLeastSpread_m = 0.0002;

}  // namespace

Vector6 ShiftTest::Spread_m() const { return variance_m2_.cwiseSqrt().cwiseMax(kLeastSpread_m); }

bool ShiftTest::Add(const Vector6& shift_m, const Vector6& assumed_sigma_m) {
  if (frames_ == 0) {
    variance_m2_ = assumed_sigma_m.cwiseAbs2();
    mean_m_ = shift_m;  // the first frame defines the displacement of rest
    frames_ = 1;
    return false;
  }
  // The mean of few frames has an error of its own.
  const double widening = std::sqrt(1 + 1.0 / frames_);
  const Vector6 innovation_m = shift_m - mean_m_;
  const Vector6 whitened = innovation_m.cwiseQuotient(widening * Spread_m());
  above_ = (above_ + whitened - Vector6::Constant(kSlack)).cwiseMax(0.0);
  below_ = (below_ - whitened - Vector6::Constant(kSlack)).cwiseMax(0.0);
  const bool suspects = above_.maxCoeff() > 0 || below_.maxCoeff() > 0;
  run_ = suspects ? run_ + 1 : 0;
  run_sum_m_ = suspects ? Vector6(run_sum_m_ + innovation_m) : Vector6(Vector6::Zero());
  if (std::max(above_.maxCoeff(), below_.maxCoeff()) > kThreshold) return true;

  // Learns slowly, and nothing from an innovation that may be a shift.
  const Vector6 held_m = innovation_m.cwiseMin(3 * Spread_m()).cwiseMax(-3 * Spread_m());
  frames_ = std::min(frames_ + 1, static_cast<int>(kMemory_frames));
  mean_m_ += held_m / frames_;
  variance_m2_ += (held_m.cwiseAbs2() - variance_m2_) / (kAssumedFrames + frames_);
  return false;
}

Vector6 ShiftTest::Shift_m() const {
  return run_ == 0 ? Vector6(Vector6::Zero()) : Vector6(run_sum_m_ / run_);
}

}  // namespace cwm::perception
