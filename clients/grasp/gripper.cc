#include "clients/grasp/gripper.h"

#include <cmath>
#include <string>

#include "absl/strings/str_cat.h"

namespace cwm::grasp {
namespace {

absl::Status CheckLength(const std::string& option, double value_m) {
  if (std::isfinite(value_m) && value_m > 0 && value_m <= 1) return absl::OkStatus();
  return absl::InvalidArgumentError(
      absl::StrCat(option, ": ", value_m, " m must be finite, positive and at most 1 m"));
}

}  // namespace

absl::Status Validate(const Gripper& gripper) {
  for (const absl::Status& status : {CheckLength("--opening", gripper.opening_m),
                                     CheckLength("--finger-length", gripper.finger_length_m),
                                     CheckLength("--finger-width", gripper.finger_width_m),
                                     CheckLength("--finger-thickness", gripper.finger_thickness_m),
                                     CheckLength("--pad-length", gripper.pad_length_m),
                                     CheckLength("--palm, x", gripper.palm_size_m.x()),
                                     CheckLength("--palm, y", gripper.palm_size_m.y()),
                                     CheckLength("--palm, z", gripper.palm_size_m.z())}) {
    if (!status.ok()) return status;
  }
  if (gripper.pad_length_m <= gripper.finger_length_m) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrCat("--pad-length: ", gripper.pad_length_m,
                                                 " m must be at most --finger-length, ",
                                                 gripper.finger_length_m, " m"));
}

std::vector<GripperBox> OpenBoxes(const Gripper& gripper) {
  const Eigen::Vector3d finger(gripper.finger_thickness_m, gripper.finger_width_m,
                               gripper.finger_length_m);
  const double x_m = (gripper.opening_m + gripper.finger_thickness_m) / 2;
  const double z_m = (gripper.tip_z_m() + gripper.palm_z_m()) / 2;
  return {{{-x_m, 0, z_m}, finger},
          {{x_m, 0, z_m}, finger},
          {{0, 0, gripper.palm_z_m() - gripper.palm_size_m.z() / 2}, gripper.palm_size_m}};
}

GripperBox ClosingBox(const Gripper& gripper) {
  return {{0, 0, (gripper.tip_z_m() + gripper.palm_z_m()) / 2},
          {gripper.opening_m, gripper.finger_width_m, gripper.finger_length_m}};
}

}  // namespace cwm::grasp
