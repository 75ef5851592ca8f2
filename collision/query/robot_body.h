// A robot as a query body: its links are the frames of the body, its states the rows.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collision/query/query.h"
#include "collision/robot/link_values.h"
#include "collision/robot/robot_model.h"
#include "collision/robot/state_range.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

// The obstacles that a robot is tested against.
enum class RobotScope { kWorld, kSelf, kBoth };

// The body of a robot, with one frame per link. Parts of two links are tested against each other if
// RobotModel::self_pairs contains the links. Shares the robot's geometry.
QueryBody BodyFromRobot(const RobotGeometry& robot, RobotScope scope);
// The same for a robot of the world, to which pair rules refer by its name.
QueryBody BodyFromRobot(const WorldRobot& robot, RobotScope scope);

// The body of a robot made of spheres, one part per sphere, ordered by link and within a link as
// listed. The sphere model has as many links as the robot. Spheres of two links are tested against
// each other if the links would be. Every answer is DEGRADED, since the distance of the spheres
// from the links' shapes is unknown. PreparedSpheres are shared; a SphereModel is prepared on each
// call.
QueryBody BodyFromSpheres(const RobotGeometry& robot, const PreparedSpheres& spheres,
                          RobotScope scope);
QueryBody BodyFromSpheres(const RobotGeometry& robot, const SphereModel& spheres, RobotScope scope);

// The body of the spheres that contain a robot's links. Free states of it are free states of the
// robot, and labelled as such; contact of its spheres is undecided. Links whose spheres touch in
// many states are tested against each other by their own geometry. Distances are DEGRADED.
QueryBody BodyFromBounds(const RobotGeometry& robot, const PreparedBounds& bounds,
                         RobotScope scope);

// Replaces the paddings of the links that are named, or all with kOtherLinks, in the body of a
// robot.
void SetPaddings(const LinkValues& paddings_m, QueryBody& body);

// Adds the pairs of links that a rule of the world checks although the robot does not
// (PairRule::check), except those that are self pairs already. `body` is the body of a robot of the
// world with its name; it is unchanged if the scope is kWorld.
QueryBody WithCheckedPairs(QueryBody body, const PairRules& rules, RobotScope scope);

// States of a robot that differ in the variables of one group.
class JointRows : public BodyRows {
 public:
  struct States {
    Pose X_WB = Pose::Identity();       // pose of the root link
    std::vector<double> base = {};      // one value per variable of the model
    std::span<const double> rows = {};  // the group's variables, row by row
  };
  // Refers to the model, the group and the rows. A group without variables has one row, the base.
  JointRows(const RobotModel& model, const JointGroup& group, States states);

  std::size_t size() const override { return count_; }
  void Place(std::size_t row, std::span<Pose> X_WL) const override;
  void PlaceRows(std::span<const std::size_t> rows, std::span<Pose> X_WL) const override;
  // True if the row is within the joint limits and all links are within the coordinates of a world.
  bool IsWithinLimits(std::size_t row) const override;
  std::optional<int> VariableOutOfLimits(std::size_t row) const override;
  // The positions that links can reach.
  const StateRange& range() const { return range_; }
  // The error of range() for the row, if it has one.
  std::optional<std::string> RangeFault(std::size_t row) const { return range_.FaultOf(Row(row)); }

  const RobotModel& model() const { return model_; }
  const JointGroup& group() const { return group_; }
  const States& states() const { return states_; }
  // All variables of the model.
  std::vector<double> State(std::size_t row) const;

 private:
  std::span<const double> Row(std::size_t row) const;

  const RobotModel& model_;
  const JointGroup& group_;
  const States states_;
  const std::size_t count_;
  const StateRange range_;
};

}  // namespace cwm::collision
