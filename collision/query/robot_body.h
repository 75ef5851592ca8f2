// A robot as what asks: its links are the frames of a body, its states the rows.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collision/query/query.h"
#include "collision/robot/robot_model.h"
#include "collision/robot/state_range.h"
#include "collision/world/world_robot.h"

namespace cwm::collision {

// Against what a robot is asked.
enum class RobotScope { kWorld, kSelf, kBoth };

// One frame per link. Parts of two links are asked of each other where RobotModel::self_pairs has
// the links. Shares the robot's geometry.
QueryBody BodyFromRobot(const RobotGeometry& robot, RobotScope scope);
// The same of a robot of the world, which rules of pairs know by its name.
QueryBody BodyFromRobot(const WorldRobot& robot, RobotScope scope);

// The same robot made of spheres, one part a sphere: by link, within a link as listed. The model
// has as many links as the robot. Spheres of two links are asked of each other where their links would
// be. Nothing is known of how far they are from the links' shapes: every answer is DEGRADED.
// Shares the prepared geometry; of a bare model it is prepared each time.
QueryBody BodyFromSpheres(const RobotGeometry& robot, const PreparedSpheres& spheres,
                          RobotScope scope);
QueryBody BodyFromSpheres(const RobotGeometry& robot, const SphereModel& spheres, RobotScope scope);

// States of a robot that differ in the variables of one group.
class JointRows : public BodyRows {
 public:
  struct States {
    Pose X_WB = Pose::Identity();       // of the root link
    std::vector<double> base = {};      // a value for each variable of the model
    std::span<const double> rows = {};  // the group's variables, row by row
  };
  // Refers to the model, to its group and to the rows. A group without variables has one row, the
  // base.
  JointRows(const RobotModel& model, const JointGroup& group, States states);

  std::size_t size() const override { return count_; }
  void Place(std::size_t row, std::span<Pose> X_WL) const override;
  void PlaceSome(std::span<const std::size_t> rows, std::span<Pose> X_WL) const override;
  // Within those of its joints, and with all links where worlds have room.
  bool IsWithinLimits(std::size_t row) const override;
  std::optional<int> VariableOutOfLimits(std::size_t row) const override;
  // Where links may get to at all.
  const StateRange& range() const { return range_; }
  // What range() finds wrong with the row.
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
