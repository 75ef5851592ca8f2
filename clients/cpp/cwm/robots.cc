#include "cwm/robots.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "cwm/error.h"

namespace cwm::CWM_API {
namespace {

template <class Named>
void AppendName(std::string* out, const Named& named) {
  out->append(named.name);
}

// The indices of the variables of a group, in its order; "": all.
std::vector<std::size_t> IndicesOf(const Robot& robot, const std::string& group) {
  std::vector<std::size_t> indices;
  if (group.empty()) {
    for (std::size_t i = 0; i < robot.variables.size(); ++i) indices.push_back(i);
    return indices;
  }
  for (const std::string& joint : robot.group(group).joints) {
    for (std::size_t i = 0; i < robot.variables.size(); ++i) {
      if (robot.variables[i].joint == joint) indices.push_back(i);
    }
  }
  return indices;
}

}  // namespace

const Group& Robot::group(const std::string& wanted) const {
  const auto found = std::find_if(groups.begin(), groups.end(),
                                  [&](const Group& group) { return group.name == wanted; });
  if (found != groups.end()) return *found;
  throw Error(ErrorCode::kNotFound,
              absl::StrCat(
                  "group \"", wanted, "\" is none of ", name, ": ",
                  groups.empty() ? "it has none" : absl::StrJoin(groups, ", ", AppendName<Group>)));
}

std::vector<Variable> Robot::VariablesOf(const std::string& group) const {
  std::vector<Variable> of_group;
  for (const std::size_t i : IndicesOf(*this, group)) of_group.push_back(variables[i]);
  return of_group;
}

Eigen::MatrixX2d Robot::Limits(const std::string& group) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const std::vector<Variable> of_group = VariablesOf(group);
  Eigen::MatrixX2d limits(static_cast<Eigen::Index>(of_group.size()), 2);
  for (Eigen::Index i = 0; i < limits.rows(); ++i) {
    const Variable& variable = of_group[static_cast<std::size_t>(i)];
    limits.row(i) << variable.lower.value_or(-kInfinity), variable.upper.value_or(kInfinity);
  }
  return limits;
}

Eigen::VectorXd Robot::Row(const std::string& group, const std::string& named_state) const {
  const std::vector<std::size_t> indices = IndicesOf(*this, group);
  std::map<std::string, double> named;
  if (!named_state.empty()) {
    const auto& known = this->group(group).states;
    const auto found = known.find(named_state);
    if (found == known.end()) {
      throw Error(ErrorCode::kNotFound,
                  absl::StrCat("\"", named_state, "\" is no state of group \"", group, "\""));
    }
    named = found->second;
  }
  Eigen::VectorXd row(static_cast<Eigen::Index>(indices.size()));
  for (Eigen::Index i = 0; i < row.size(); ++i) {
    const std::size_t index = indices[static_cast<std::size_t>(i)];
    const auto value = named.find(variables[index].name);
    row[i] = value != named.end() ? value->second : state[static_cast<Eigen::Index>(index)];
  }
  return row;
}

}  // namespace cwm::CWM_API
