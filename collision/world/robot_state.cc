#include "collision/world/robot_state.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string_view>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/robot/mimic.h"
#include "collision/world/apply_fault.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

constexpr double kQuaternionTolerance = 0.01;  // as in OutOfLimits
constexpr int kQuaternionAt = 3, kQuaternionEnd = 7;

bool IsInRange(double value) { return std::abs(value) <= kMaxCoordinate_m; }  // not NaN

// Sets the values of single variables, one after the other.
class Setter {
 public:
  Setter(const RobotModel& model, std::vector<double> state)
      : model_(model), state_(std::move(state)), is_set_(model.variables.size()) {
    for (std::size_t i = 0; i < model.variables.size(); ++i) {
      index_[model.variables[i].name] = static_cast<int>(i);
    }
  }

  absl::Status SetNamed(const JointValues::Named& named) {
    const JointGroup* group = model_.FindGroup(named.group);
    if (group == nullptr) {
      return InvalidFieldError("group", absl::StrCat("is ", Quoted(named.group),
                                                     ", must be a group of ", Quoted(model_.name)));
    }
    const auto state = std::find_if(group->states.begin(), group->states.end(),
                                    [&](const NamedState& s) { return s.name == named.state; });
    if (state == group->states.end()) {
      return InvalidFieldError(
          "named_state",
          absl::StrCat("is ", Quoted(named.state), ", must be a state of ", Quoted(named.group)));
    }
    if (state->variables.empty()) {
      return InvalidFieldError(
          "named_state", absl::StrCat("is ", Quoted(named.state),
                                      ", of which the SRDF says nothing that joints of ",
                                      Quoted(named.group), " can take: load the robot to see why"));
    }
    for (std::size_t i = 0; i < state->variables.size(); ++i) {
      state_[state->variables[i]] = state->values[i];
    }
    return absl::OkStatus();
  }

  absl::Status Set(const VariableValue& value, const std::string& place) {
    if (!IsInRange(value.value)) {
      return InvalidFieldError(place + ".value",
                               absl::StrCat("is ", value.value, ", must be finite and at most ",
                                            kMaxCoordinate_m, " in magnitude"));
    }
    const auto variable = index_.find(value.variable);
    if (variable == index_.end()) return CheckOther(value, place);
    if (is_set_[variable->second]) {
      return InvalidFieldError(place + ".variable",
                               absl::StrCat("is ", Quoted(value.variable), ", must be named once"));
    }
    is_set_[variable->second] = true;
    state_[variable->second] = value.value;
    return absl::OkStatus();
  }

  // Checks the values of mimic joints, after all variables are set.
  absl::Status CheckMimics() const {
    for (const auto& [link, value, place] : mimics_) {
      const ModelLink& follower = model_.links[link];
      const double expected = follower.multiplier * state_[follower.variable] + follower.offset;
      if (std::abs(value - expected) <= kMimicTolerance) continue;
      return InvalidFieldError(place + ".value",
                               absl::StrCat("is ", value, ", must be left out or ", expected,
                                            ": joint ", Quoted(follower.joint), " mimics another"));
    }
    return absl::OkStatus();
  }

  absl::Status CheckQuaternions() const {
    for (std::size_t i = 0; i < state_.size(); ++i) {
      const Variable& variable = model_.variables[i];
      const ModelLink& link = model_.links[variable.link];
      if (link.kind != JointKind::kFloating || variable.component != 0) continue;
      double square = 0;
      for (int q = kQuaternionAt; q < kQuaternionEnd; ++q) square += state_[i + q] * state_[i + q];
      if (std::abs(std::sqrt(square) - 1) <= kQuaternionTolerance) continue;
      return InvalidFieldError(
          "values", absl::StrCat("turn joint ", Quoted(link.joint), " by a quaternion of length ",
                                 std::sqrt(square), ", must have length 1 within 1 %"));
    }
    return absl::OkStatus();
  }

  std::vector<double> Take() && { return std::move(state_); }

 private:
  struct MimicJoint {
    int link = 0;
    double value = 0;
    std::string place;
  };

  absl::Status CheckOther(const VariableValue& value, const std::string& place) {
    const std::optional<int> link = model_.FindJoint(value.variable);
    if (link.has_value() && model_.links[*link].kind == JointKind::kFixed) {
      if (value.value == 0) return absl::OkStatus();
      return InvalidFieldError(place + ".value",
                               absl::StrCat("is ", value.value, ", must be left out or 0: joint ",
                                            Quoted(value.variable), " is fixed"));
    }
    if (link.has_value() && model_.links[*link].is_mimic) {
      mimics_.push_back({*link, value.value, place});
      return absl::OkStatus();
    }
    return InvalidFieldError(place + ".variable",
                             absl::StrCat("is ", Quoted(value.variable), ", must be a variable of ",
                                          Quoted(model_.name)));
  }

  const RobotModel& model_;
  std::vector<double> state_;
  std::vector<bool> is_set_;
  std::map<std::string_view, int> index_;
  std::vector<MimicJoint> mimics_;
};

}  // namespace

absl::StatusOr<std::vector<double>> StateWith(const RobotModel& model, std::vector<double> state,
                                              const JointValues& joints) {
  Setter setter(model, std::move(state));
  if (joints.named.has_value()) {
    if (auto status = setter.SetNamed(*joints.named); !status.ok()) return status;
  }
  for (std::size_t i = 0; i < joints.values.size(); ++i) {
    const absl::Status status = setter.Set(joints.values[i], absl::StrCat("values[", i, "]"));
    if (!status.ok()) return status;
  }
  if (auto status = setter.CheckMimics(); !status.ok()) return status;
  if (auto status = setter.CheckQuaternions(); !status.ok()) return status;
  return std::move(setter).Take();
}

bool IsState(const RobotModel& model, const std::vector<double>& state) {
  return state.size() == model.variables.size() &&
         std::all_of(state.begin(), state.end(), IsInRange);
}

}  // namespace cwm::collision
