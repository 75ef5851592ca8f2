// Checks that states keep a robot's links in the range of world coordinates. Beyond
// kMaxCoordinate_m distances are inaccurate, and with NaN every comparison reports "apart".
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// Refuses a robot whose fixed lengths may add up to more than kMaxCoordinate_m between the root
// and a link. These lengths are the origins of the joints on the way (a run of fixed joints counts
// as one length) and the offsets of prismatic mimic joints.
absl::Status CheckReach(const RobotModel& model);

// The check for the states of a group. Immutable; refers to the model and to the group.
class StateRange {
 public:
  // `base` has a value for each variable of the model; those of the group are not read.
  StateRange(const RobotModel& model, const JointGroup& group, const Pose& X_WB,
             std::vector<double> base);

  // The fault of a row, e.g. "puts link \"hand\" at (2e+06, 0, 1), must be within 1e+06 m of the
  // world's origin along each axis"; empty if there is none. A row is faulty if a link is out of
  // range or not finite, or if a mimic joint is beyond kMaxCoordinate_m, in rad or m. A row has
  // one value for each variable of the group.
  std::optional<std::string> FaultOf(std::span<const double> row) const;

  // True if a row may have a fault. Without sliding joints and mimic joints, either all rows have
  // one or none has.
  bool MayHaveFaults() const { return !columns_.empty() || !IsCertainlyInside({}); }

  // The largest distance of a link from the world's origin, while each sliding joint that the group
  // moves, and each axis of planar and floating joints, is at most `slide_m` from 0. Infinite if
  // the base puts a mimic joint out of range.
  double Reach_m(double slide_m) const { return rest_m_ + slide_m * slides_; }

 private:
  // A variable of a row that moves links away from the root.
  struct Column {
    std::size_t at = 0;
    double slide = 0;     // metres per unit, summed over the links that it moves
    double farthest = 0;  // beyond this a mimic joint is out of range
  };

  bool IsCertainlyInside(std::span<const double> row) const;

  const RobotModel& model_;
  const JointGroup& group_;
  const Pose X_WB_;
  std::vector<double> base_;
  std::vector<Column> columns_;  // those that matter
  double rest_m_ = 0;            // largest distance of a link from the world's origin without them
  int slides_ = 0;               // number of sliding axes of the group
};

// The fault of a single state of all variables.
std::optional<std::string> StateFault(const RobotModel& model, const Pose& X_WB,
                                      std::span<const double> state);

}  // namespace cwm::collision
