#include "collision/robot/named_states.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "absl/strings/str_cat.h"
#include "collision/robot/mimic.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

class StateMaker {
 public:
  StateMaker(const SemanticState& semantic, const RobotModel& model, const JointGroup& group,
             SkippedElements& left_out)
      : semantic_(semantic), model_(model), group_(group), left_out_(left_out) {}

  NamedState Make() {
    for (const JointPosition& position : semantic_.positions) {
      if (!LinkOf(position).is_mimic) Take(position);
    }
    // The values of joints themselves take precedence over those derived from their mimic joints.
    for (const JointPosition& position : semantic_.positions) {
      if (LinkOf(position).is_mimic) SetMimicSource(position);
    }
    NamedState state{.name = semantic_.name, .variables = {}, .values = {}};
    for (const auto& [variable, value] : values_) {
      state.variables.push_back(variable);
      state.values.push_back(value);
    }
    return state;
  }

 private:
  const ModelLink& LinkOf(const JointPosition& position) const {
    return model_.links[static_cast<std::size_t>(*model_.FindJoint(position.joint))];
  }

  bool IsOfGroup(const ModelLink& link) const {
    return std::binary_search(group_.variables.begin(), group_.variables.end(), link.variable);
  }

  void Take(const JointPosition& position) {
    const ModelLink& link = LinkOf(position);
    const auto count = static_cast<std::size_t>(VariableCount(link.kind));
    if (count == 0) return Skip(position, "is fixed");
    if (position.values.size() != count) {
      return Skip(position, absl::StrCat("has ", position.values.size(), " values, not ", count));
    }
    if (!IsOfGroup(link)) {
      return Skip(position, absl::StrCat("is not one of group ", Quoted(group_.name)));
    }
    for (std::size_t i = 0; i < count; ++i) {
      values_[link.variable + static_cast<int>(i)] = position.values[i];
    }
  }

  void SetMimicSource(const JointPosition& position) {
    const ModelLink& link = LinkOf(position);
    const std::string& leader =
        model_.variables[static_cast<std::size_t>(link.variable)].name;  // its only variable
    if (!IsOfGroup(link)) {
      return Skip(position, absl::StrCat("follows ", Quoted(leader), ", which is not one of group ",
                                         Quoted(group_.name)));
    }
    const double value = position.values.front();
    const auto said = values_.find(link.variable);
    if (said == values_.end() && link.multiplier != 0) {
      values_[link.variable] = (value - link.offset) / link.multiplier;
      return;
    }
    const double expected =
        link.offset + (link.multiplier != 0 ? link.multiplier * said->second : 0);
    if (std::abs(value - expected) <= kMimicTolerance) return;
    Skip(position, absl::StrCat("is ", value, ", but ", Quoted(leader), " puts it at ", expected));
  }

  void Skip(const JointPosition& position, const std::string& why) {
    left_out_.Add(absl::StrCat("srdf: group_state ", Quoted(semantic_.name), ": joint ",
                               Quoted(position.joint), " ", why));
  }

  const SemanticState& semantic_;
  const RobotModel& model_;
  const JointGroup& group_;
  SkippedElements& left_out_;
  std::map<int, double> values_;  // by variable
};

}  // namespace

NamedState MakeNamedState(const SemanticState& semantic, const RobotModel& model,
                          const JointGroup& group, SkippedElements& left_out) {
  return StateMaker(semantic, model, group, left_out).Make();
}

}  // namespace cwm::collision
