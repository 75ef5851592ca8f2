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
// chosen: innovations have longer tails than a normal distribution, so that one counts as at most
// so many standard deviations, and no shift is told by two frames.
constexpr double kMaxWhitened = 4;
// chosen: a shift that is told only after two seconds is as good as drift.
constexpr std::size_t kLongestRun_frames = 60;

}  // namespace

Vector6 ShiftTest::Spread_m(const Vector6& assumed_sigma_m) const {
  const Vector6 factor = variance_ratio_.cwiseSqrt().cwiseMax(kMinOfAssumed);
  return factor.cwiseProduct(assumed_sigma_m).cwiseMax(kMinSpread_m);
}

bool ShiftTest::Add(const Vector6& shift_m, const Vector6& assumed_sigma_m) {
  if (frames_ == 0) {
    mean_m_ = shift_m;  // the first frame defines the displacement of rest
    frames_ = 1;
    return false;
  }
  const bool has_learnt = frames_ >= kLearning_frames;
  // The mean of few frames has an error of its own.
  const double widening = std::sqrt(1 + 1.0 / frames_);
  const Vector6 innovation_m = shift_m - mean_m_;
  const Vector6 spread_m = Spread_m(assumed_sigma_m);
  const Vector6 whitened = innovation_m.cwiseQuotient(widening * spread_m)
                               .cwiseMin(kMaxWhitened)
                               .cwiseMax(-kMaxWhitened);
  if (has_learnt) {
    above_ = (above_ + whitened - Vector6::Constant(kSlack)).cwiseMax(0);
    below_ = (below_ - whitened - Vector6::Constant(kSlack)).cwiseMax(0);
  }
  recent_m_.push_back(innovation_m);
  if (recent_m_.size() > kLongestRun_frames) recent_m_.pop_front();
  if (std::max(above_.maxCoeff(), below_.maxCoeff()) > kThreshold) {
    shift_m_ = MeanSinceShift(spread_m);
    return true;
  }

  // Learns slowly, and nothing from an innovation that may be a shift.
  const Vector6 held_m = innovation_m.cwiseMin(3 * spread_m).cwiseMax(-3 * spread_m);
  frames_ = std::min(frames_ + 1, static_cast<int>(kMemory_frames));
  mean_m_ += held_m / frames_;
  const Vector6 ratio = held_m.cwiseQuotient(assumed_sigma_m.cwiseMax(kMinSpread_m)).cwiseAbs2();
  variance_ratio_ += (ratio - variance_ratio_) / (kAssumedFrames + frames_);
  return false;
}

// The shift began with the frame since which it is the most likely, by the generalised likelihood
// ratio (Basseville and Nikiforov 1993, "Detection of abrupt changes").
Vector6 ShiftTest::MeanSinceShift(const Vector6& spread_m) const {
  Vector6 sum_m = Vector6::Zero();
  Vector6 likeliest_m = Vector6::Zero();
  double greatest = 0;
  for (std::size_t count = 1; count <= recent_m_.size(); ++count) {
    sum_m += recent_m_[recent_m_.size() - count];
    const Vector6 mean_m = sum_m / static_cast<double>(count);
    const double ratio = static_cast<double>(count) * mean_m.cwiseQuotient(spread_m).squaredNorm();
    if (ratio <= greatest) continue;
    greatest = ratio;
    likeliest_m = mean_m;
  }
  return likeliest_m;
}

}  // namespace cwm::perception
