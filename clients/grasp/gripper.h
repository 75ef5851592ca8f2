// A parallel gripper as boxes, in the frame of a grasp.
//
// Frame G of a grasp: the origin is midway between the pads, on the line along which they close; z
// is the approach, from the palm to the tips; x is the closing direction, from the finger at -x to
// the one at +x; y = z cross x is along the width of the fingers. The gripper is symmetric under
// half a turn about z.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "absl/status/status.h"

namespace cwm::grasp {

// The defaults are those of a Franka hand, rounded up.
struct Gripper {
  double opening_m = 0.08;           // between the open pads
  double finger_length_m = 0.045;    // from the palm to the tips
  double finger_width_m = 0.02;      // along y
  double finger_thickness_m = 0.01;  // along x
  double pad_length_m = 0.02;        // of the pads along z; they end at the tips
  Eigen::Vector3d palm_size_m{0.204, 0.063, 0.066};

  double tip_z_m() const { return pad_length_m / 2; }
  double palm_z_m() const { return tip_z_m() - finger_length_m; }  // its face towards the tips
};

// INVALID_ARGUMENT with the option, its value and the rule: all lengths are finite, positive and at
// most 1 m, and a pad is no longer than its finger.
absl::Status Validate(const Gripper& gripper);

struct GripperBox {
  Eigen::Vector3d centre_G;
  Eigen::Vector3d size_m;
};

// The finger at -x, the one at +x and the palm, of the fully open gripper.
std::vector<GripperBox> OpenBoxes(const Gripper& gripper);
// The box that the fingers sweep while they close from the open position.
GripperBox ClosingBox(const Gripper& gripper);

}  // namespace cwm::grasp
