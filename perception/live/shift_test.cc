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
// chosen: nothing is told before so many frames, of which the sensor's reference takes the first.
constexpr int kLearning_frames = 15;
// chosen: the mean follows slow drift, as of a sensor that warms up, within ten seconds at 30 Hz.
constexpr double kMemory_frames = 300;
// chosen: spreads below a fifth of a millimetre, or half of the assumed one, are luck: some frames
// are alike by chance.
constexpr double kMinSpread_m = 0.0002;
constexpr double kMinOfAssumed = 0.5;
// chosen: a shift that is told only after two seconds is as good as drift.
constexpr std::size_t kLongestRun_frames = 60;

}  // namespace

Vector6 ShiftTest::Spread_m() const { return variance_m2_.cwiseSqrt().cwiseMax(least_spread_m_); }

bool ShiftTest::Add(const Vector6& shift_m, const Vector6& assumed_sigma_m) {
  if (frames_ == 0) {
    variance_m2_ = assumed_sigma_m.cwiseAbs2();
    least_spread_m_ = (kMinOfAssumed * assumed_sigma_m).cwiseMax(kMinSpread_m);
    mean_m_ = shift_m;  // the first frame defines the displacement of rest
    frames_ = 1;
    return false;
  }
  const bool has_learnt = frames_ >= kLearning_frames;
  // The mean of few frames has an error of its own.
  const double widening = std::sqrt(1 + 1.0 / frames_);
  const Vector6 innovation_m = shift_m - mean_m_;
  const Vector6 whitened = innovation_m.cwiseQuotient(widening * Spread_m());
  if (has_learnt) {
    Add(whitened, above_);
    Add(-whitened, below_);
  }
  recent_m_.push_back(innovation_m);
  if (recent_m_.size() > kLongestRun_frames) recent_m_.pop_front();
  int component = 0;
  const bool is_above = above_.sum.maxCoeff() >= below_.sum.maxCoeff();
  const Sums& larger = is_above ? above_ : below_;
  if (larger.sum.maxCoeff(&component) > kThreshold) {
    shift_m_ = MeanOverRun(larger, component);
    return true;
  }

  // Learns slowly, and nothing from an innovation that may be a shift.
  const Vector6 held_m = innovation_m.cwiseMin(3 * Spread_m()).cwiseMax(-3 * Spread_m());
  frames_ = std::min(frames_ + 1, static_cast<int>(kMemory_frames));
  mean_m_ += held_m / frames_;
  variance_m2_ += (held_m.cwiseAbs2() - variance_m2_) / (kAssumedFrames + frames_);
  return false;
}

void ShiftTest::Add(const Vector6& whitened, Sums& sums) {
  for (int i = 0; i < 6; ++i) {
    sums.sum[i] = std::max(0.0, sums.sum[i] + whitened[i] - kSlack);
    sums.run[i] = sums.sum[i] > 0 ? sums.run[i] + 1 : 0;
  }
}

Vector6 ShiftTest::MeanOverRun(const Sums& sums, int component) const {
  const std::size_t count =
      std::min(recent_m_.size(), static_cast<std::size_t>(sums.run[component]));
  Vector6 sum_m = Vector6::Zero();
  for (std::size_t i = recent_m_.size() - count; i < recent_m_.size(); ++i) sum_m += recent_m_[i];
  return sum_m / static_cast<double>(count);
}

}  // namespace cwm::perception
