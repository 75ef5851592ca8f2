#include "collision/query/robot_body.h"

#include <utility>

#include "absl/container/inlined_vector.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

// The variables of a state. Robots with one or two arms need no allocation.
using Variables = absl::InlinedVector<double, 32>;

void SetGroup(const JointGroup& group, std::span<const double> row, std::span<double> variables) {
  for (std::size_t k = 0; k < row.size(); ++k) {
    variables[static_cast<std::size_t>(group.variables[k])] = row[k];
  }
}

Variables With(const std::vector<double>& base, const JointGroup& group,
               std::span<const double> row) {
  Variables variables(base.begin(), base.end());
  SetGroup(group, row, {variables.data(), variables.size()});
  return variables;
}

// Sets the frames, one per link, and the self pairs of a body that already has its parts.
void SetScope(const RobotGeometry& robot, RobotScope scope, QueryBody& body) {
  const RobotModel& model = *robot.model;
  body.robot = robot.model;
  body.programs = robot.programs;
  body.frame_count = static_cast<int>(model.links.size());
  body.tests_world = scope != RobotScope::kSelf;
  if (scope == RobotScope::kWorld) return;
  std::vector<std::vector<std::int32_t>> parts_of_link(model.links.size());
  for (std::size_t part = 0; part < body.frame_of_part.size(); ++part) {
    parts_of_link[static_cast<std::size_t>(body.frame_of_part[part])].push_back(
        static_cast<std::int32_t>(part));
  }
  for (const auto& [first, second] : model.self_pairs) {
    for (std::int32_t a : parts_of_link[static_cast<std::size_t>(first)]) {
      for (std::int32_t b : parts_of_link[static_cast<std::size_t>(second)]) {
        body.self_pairs.push_back({a, b});
      }
    }
  }
}

}  // namespace

QueryBody BodyFromRobot(const RobotGeometry& robot, RobotScope scope) {
  QueryBody body{.geometry = robot.geometry, .frame_of_part = robot.link_of_part};
  body.bounding_spheres = robot.bounding_spheres;
  SetScope(robot, scope, body);
  return body;
}

QueryBody BodyFromRobot(const WorldRobot& robot, RobotScope scope) {
  QueryBody body = BodyFromRobot(*robot.robot, scope);
  body.self = robot.name;
  return body;
}

QueryBody BodyFromSpheres(const RobotGeometry& robot, const PreparedSpheres& spheres,
                          RobotScope scope) {
  QueryBody body{.geometry = spheres.geometry, .frame_of_part = spheres.link_of_part};
  body.best_accuracy = Accuracy::kDegraded;
  SetScope(robot, scope, body);
  return body;
}

QueryBody BodyFromSpheres(const RobotGeometry& robot, const SphereModel& spheres,
                          RobotScope scope) {
  return BodyFromSpheres(robot, PrepareSpheres(spheres), scope);
}

JointRows::JointRows(const RobotModel& model, const JointGroup& group, States states)
    : model_(model),
      group_(group),
      states_(std::move(states)),
      count_(group.variables.empty() ? 1 : states_.rows.size() / group.variables.size()),
      range_(model, group, states_.X_WB, states_.base) {}

std::span<const double> JointRows::Row(std::size_t row) const {
  const std::size_t width = group_.variables.size();
  return states_.rows.subspan(row * width, width);
}

void JointRows::Place(std::size_t row, std::span<Pose> X_WL) const { PlaceRows({&row, 1}, X_WL); }

void JointRows::PlaceRows(std::span<const std::size_t> rows, std::span<Pose> X_WL) const {
  absl::InlinedVector<double, 64> states;  // enough for eight states of a robot with one arm
  for (std::size_t row : rows) {
    states.insert(states.end(), states_.base.begin(), states_.base.end());
    SetGroup(group_, Row(row), std::span(states.data(), states.size()).last(states_.base.size()));
  }
  LinkPosesOfStates(model_, states_.X_WB, {states.data(), states.size()}, X_WL);
}

bool JointRows::IsWithinLimits(std::size_t row) const {
  return !VariableOutOfLimits(row).has_value() && !RangeFault(row).has_value();
}

std::optional<int> JointRows::VariableOutOfLimits(std::size_t row) const {
  return OutOfLimits(model_, With(states_.base, group_, Row(row)));
}

std::vector<double> JointRows::State(std::size_t row) const {
  const Variables variables = With(states_.base, group_, Row(row));
  return {variables.begin(), variables.end()};
}

}  // namespace cwm::collision
