// Whether states leave a robot where worlds have room. Beyond kLargestCoordinate_m distances are not
// what they claim to be, and of what is no number every comparison says "apart".
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "collision/robot/robot_model.h"

namespace cwm::collision {

// Refuses a robot whose fixed lengths may add up to more than kLargestCoordinate_m between the root and
// a link: the origins of joints along the way, those of fixed joints as the one length that they are
// together, and what sliding joints that follow others are offset by.
absl::Status CheckReach(const RobotModel& model);

// Of the states of a group. Immutable, refers to the model and to the group.
class StateRange {
 public:
  // `base` has a value for each variable of the model; those of the group are not read.
  StateRange(const RobotModel& model, const JointGroup& group, const Pose& X_WB,
             std::vector<double> base);

  // What is wrong with a row, e.g. "puts link \"hand\" at (2e+06, 0, 1), must be within 1e+06 m of the
  // world's origin along each axis": a link there or nowhere at all, or a joint that follows another by
  // more than kLargestCoordinate_m, rad or m. A row is one value for each variable of the group.
  std::optional<std::string> FaultOf(std::span<const double> row) const;

  // Whether there are rows with a fault: without sliding joints and followers all rows have one or none.
  bool MayHaveFaults() const { return !columns_.empty() || !IsPlainlyInside({}); }

  // No link is farther from the world's origin than this while each sliding joint that the group moves
  // is at most so far from 0, as is each axis of planar and floating ones. Infinite where the base puts
  // a follower out of range.
  double Reach_m(double slide_m) const { return rest_m_ + slide_m * slides_; }

 private:
  // Of a row, what takes links away from the root.
  struct Column {
    std::size_t at = 0;
    double slide = 0;     // m for each unit: of all links that it moves together
    double farthest = 0;  // beyond, a follower is out of range
  };

  bool IsPlainlyInside(std::span<const double> row) const;

  const RobotModel& model_;
  const JointGroup& group_;
  const Pose X_WB_;
  std::vector<double> base_;
  std::vector<Column> columns_;  // those that matter
  double rest_m_ = 0;            // from the world's origin to any link without them
  int slides_ = 0;               // how many axes of the group slide
};

// The same of one state.
std::optional<std::string> StateFault(const RobotModel& model, const Pose& X_WB,
                                      std::span<const double> state);

}  // namespace cwm::collision
