#include "server/wire/robot_states.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/xml/xml_element.h"
#include "server/wire/poses.h"
#include "server/wire/queries.h"
#include "server/wire/times.h"

namespace cwm::server {
namespace {

using collision::JointGroup;
using collision::Quoted;
using collision::RobotModel;

std::optional<int> FindVariable(const RobotModel& model, const std::string& name) {
  const auto found = std::ranges::find(model.variables, name, &collision::Variable::name);
  if (found == model.variables.end()) return std::nullopt;
  return static_cast<int>(found - model.variables.begin());
}

const collision::Variable& VariableAt(const RobotModel& model, int index) {
  return model.variables[static_cast<std::size_t>(index)];
}

// The first of the variables that lacks the one before it or after it of the same joint.
std::optional<int> FindTornApart(const RobotModel& model, const std::vector<int>& variables) {
  const auto is_joined = [&](std::size_t i, int step) {
    const int neighbour = variables[i] + step;
    const bool exists = neighbour >= 0 && neighbour < static_cast<int>(model.variables.size());
    if (!exists || VariableAt(model, neighbour).link != VariableAt(model, variables[i]).link) {
      return true;
    }
    const std::size_t at = i + static_cast<std::size_t>(step);  // wraps to past the end
    return at < variables.size() && variables[at] == neighbour;
  };
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (!is_joined(i, -1) || !is_joined(i, 1)) return static_cast<int>(i);
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<JointGroup> ToldVariablesFromProto(const v1::RobotStatesHeader& header,
                                                  const RobotModel& model, const FieldPath& path) {
  JointGroup told = model.all;
  if (header.variables().empty()) return told;
  told.variables.clear();
  told.joints.clear();
  for (int i = 0; i < header.variables_size(); ++i) {
    const std::string& name = header.variables(i);
    const auto index = FindVariable(model, name);
    if (!index.has_value()) {
      return path.Item("variables", i)
          .Error(absl::StrCat("is ", Quoted(name), ", must be a variable of the robot"));
    }
    if (std::ranges::find(told.variables, *index) != told.variables.end()) {
      return path.Item("variables", i).Error(absl::StrCat("is ", Quoted(name), ", named twice"));
    }
    told.variables.push_back(*index);
    told.joints.push_back(
        model.links[static_cast<std::size_t>(VariableAt(model, *index).link)].joint);
  }
  if (const auto torn = FindTornApart(model, told.variables)) {
    return path.Item("variables", *torn)
        .Error(absl::StrCat("is ", Quoted(header.variables(*torn)),
                            ", must stand with all variables of its joint, in their order"));
  }
  return told;
}

absl::StatusOr<std::vector<StampedRobotState>> StampedStatesFromProto(
    const v1::RobotStateRows& states, const collision::WorldRobotPtr& robot, const JointGroup& told,
    std::int64_t max_rows, const FieldPath& path) {
  const int count = states.stamps_size();
  if (count > max_rows) {
    return path.Field("stamps").Error(
        absl::StrCat("has ", count, " entries, must have at most ", max_rows));
  }
  RobotRows rows{.robot = robot, .group = &told, .X_WB = robot->X_WB, .base = robot->state};
  const FieldPath rows_path = path.Field("rows");
  const std::size_t width = told.variables.size();
  if (width > 0 && states.rows().data().empty() && count > 0) {
    return rows_path.Field("data").Error(
        absl::StrCat("is empty, must have a row for each of the ", count, " stamps"));
  }
  if (count > 0) {
    if (auto read = ReadJointRows(states.rows(), max_rows, rows_path, nullptr, rows); !read.ok()) {
      return read;
    }
  }
  if (width > 0 && rows.rows.size() != static_cast<std::size_t>(count) * width) {
    return rows_path.Error(absl::StrCat("has ", rows.rows.size() / width, " rows, must have ",
                                        count, ", one for each stamp"));
  }
  const auto bases = PosesFromProto(states.x_world_base(), max_rows, path.Field("x_world_base"));
  if (!bases.ok()) return bases.status();
  if (!bases->empty() && static_cast<int>(bases->size()) != count) {
    return path.Field("x_world_base")
        .Error(absl::StrCat("has ", bases->size(), " poses, must have none, or ", count,
                            ", one for each stamp"));
  }
  std::vector<StampedRobotState> stamped(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    StampedRobotState& state = stamped[static_cast<std::size_t>(i)];
    const auto stamp = TimePointFromProto(states.stamps(i), path.Item("stamps", i));
    if (!stamp.ok()) return stamp.status();
    state.stamp = *stamp;
    const auto row = rows.rows.begin() + static_cast<std::ptrdiff_t>(width) * i;
    state.values.assign(row, row + static_cast<std::ptrdiff_t>(width));
    if (!bases->empty()) state.X_WB = (*bases)[static_cast<std::size_t>(i)];
  }
  return stamped;
}

}  // namespace cwm::server
