// Tells the shift of a body at rest from the noise of its measured displacement.
#pragma once

#include <deque>

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// A two-sided CUSUM of each component (Page 1954, "Continuous inspection schemes"), on innovations
// whitened by the spread that was measured while the body rested. A value: copies are independent.
class ShiftTest {
 public:
  // Takes the displacement measured in one frame, each component in metres, and the standard
  // deviations that are assumed before enough frames were measured. True if the body has shifted.
  bool Add(const Vector6& shift_m, const Vector6& assumed_sigma_m);

  // The mean displacement over the frames since the shift began, less the usual one. Zero unless
  // the last Add returned true.
  Vector6 Shift_m() const { return shift_m_; }

  // Forgets all frames.
  void Reset() { *this = ShiftTest(); }

 private:
  Vector6 Spread_m() const;

  int frames_ = 0;
  Vector6 mean_m_ = Vector6::Zero();  // the usual displacement: warp that the reference lacks
  Vector6 variance_m2_ = Vector6::Zero();
  Vector6 least_spread_m_ = Vector6::Zero();
  // One sided sums in standard deviations, at least 0, and the frames since each was zero: above
  // the mean, then below.
  struct Sums {
    Vector6 sum = Vector6::Zero();
    Eigen::Matrix<int, 6, 1> run = Eigen::Matrix<int, 6, 1>::Zero();
  };
  static void Add(const Vector6& whitened, Sums& sums);
  Vector6 MeanOverRun(const Sums& sums, int component) const;

  Sums above_ = {};
  Sums below_ = {};
  std::deque<Vector6> recent_m_;  // innovations, the newest last
  Vector6 shift_m_ = Vector6::Zero();
};

}  // namespace cwm::perception
