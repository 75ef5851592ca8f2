// Tells the shift of a body at rest from the noise of its measured displacement.
#pragma once

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// A two-sided CUSUM of each component (Page 1954, "Continuous inspection schemes"), on innovations
// whitened by the spread that was measured while the body rested. A value: copies are independent.
class ShiftTest {
 public:
  // Takes the displacement measured in one frame, each component in metres, and the standard
  // deviations that are assumed before enough frames were measured. True if the body has shifted.
  bool Add(const Vector6& shift_m, const Vector6& assumed_sigma_m);

  // The mean displacement over the frames since the shift began, less the usual one.
  Vector6 Shift_m() const;

  // Forgets all frames.
  void Reset() { *this = ShiftTest(); }

 private:
  Vector6 Spread_m() const;

  int frames_ = 0;
  Vector6 mean_m_ = Vector6::Zero();  // the usual displacement: warp that the reference lacks
  Vector6 variance_m2_ = Vector6::Zero();
  Vector6 above_ = Vector6::Zero();  // sums in standard deviations, at least 0
  Vector6 below_ = Vector6::Zero();
  int run_ = 0;  // frames since all sums were zero
  Vector6 run_sum_m_ = Vector6::Zero();
};

}  // namespace cwm::perception
