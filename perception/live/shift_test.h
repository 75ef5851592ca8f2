// Tells the shift of a body at rest from the noise of its measured displacement.
#pragma once

#include <deque>

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// A two-sided CUSUM of each component (Page 1954, "Continuous inspection schemes"), on innovations
// whitened by the standard deviations of their frame, times a factor that was measured while the
// body rested. A value: copies are independent.
class ShiftTest {
 public:
  // Takes the displacement measured in one frame, each component in metres, and the standard
  // deviations that are assumed of it; by what factor they are wrong, the same in all frames, is
  // learnt. True if the body has shifted.
  bool Add(const Vector6& shift_m, const Vector6& assumed_sigma_m);

  // The mean displacement, less the usual one, over the frames since the shift began, most likely.
  // Zero unless the last Add returned true.
  Vector6 Shift_m() const { return shift_m_; }

  // Forgets all frames.
  void Reset() { *this = ShiftTest(); }

 private:
  Vector6 Spread_m(const Vector6& assumed_sigma_m) const;

  int frames_ = 0;
  Vector6 mean_m_ = Vector6::Zero();  // the usual displacement: warp that the reference lacks
  Vector6 variance_ratio_ = Vector6::Ones();  // of the measured variance to the assumed one
  Vector6 MeanSinceShift(const Vector6& spread_m) const;

  // One sided sums in standard deviations, at least 0: above the mean, and below.
  Vector6 above_ = Vector6::Zero();
  Vector6 below_ = Vector6::Zero();
  std::deque<Vector6> recent_m_;  // innovations, the newest last
  Vector6 shift_m_ = Vector6::Zero();
};

}  // namespace cwm::perception
