#include "collision/inverse_kinematics/ik_chain.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

std::vector<int> LinksTo(const RobotModel& model, int link) {
  std::vector<int> links;
  for (int at = link; at != 0; at = model.links[static_cast<std::size_t>(at)].parent) {
    links.push_back(at);
  }
  std::ranges::reverse(links);
  return links;
}

class ChainMaker {
 public:
  ChainMaker(const RobotModel& model, const JointGroup& group) : model_(model), group_(group) {}

  absl::StatusOr<IkChain> Make(std::span<const double> base, int link, const Pose& X_LT) {
    // Poses of the links in the state `base`: constant joints are taken from them.
    std::vector<Pose> X_BL(model_.links.size());
    LinkPoses(model_, Pose::Identity(), base, X_BL);
    for (const int at : LinksTo(model_, link)) {
      const ModelLink& child = model_.links[static_cast<std::size_t>(at)];
      const auto of_group = std::ranges::find(group_.variables, child.variable);
      if (child.kind == JointKind::kFixed || of_group == group_.variables.end()) {
        const Pose& X_BP = X_BL[static_cast<std::size_t>(child.parent)];
        X_JL_ = X_JL_ * X_BP.inverse(Eigen::Isometry) * X_BL[static_cast<std::size_t>(at)];
        continue;
      }
      if (absl::Status status = Add(child, of_group - group_.variables.begin()); !status.ok()) {
        return status;
      }
    }
    if (chain_.joints.empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("no joint of group \"", group_.name, "\" moves link \"",
                       model_.links[static_cast<std::size_t>(link)].name, "\""));
    }
    if (chain_.joints.size() > kMaxIkJoints || chain_.variables.size() > kMaxIkVariables) {
      return absl::InvalidArgumentError(absl::StrCat(
          "the tool is moved by ", chain_.joints.size(), " joints with ", chain_.variables.size(),
          " variables, must be at most ", kMaxIkJoints, " with ", kMaxIkVariables));
    }
    chain_.X_JT = X_JL_ * X_LT;
    SetNumbers();
    return std::move(chain_);
  }

 private:
  absl::Status Add(const ModelLink& child, std::ptrdiff_t of_group) {
    const bool turns = child.kind == JointKind::kRevolute || child.kind == JointKind::kContinuous;
    if (!turns && child.kind != JointKind::kPrismatic) {
      return absl::InvalidArgumentError(
          absl::StrCat("joint \"", child.joint, "\" is ", std::string(NameOf(child.kind)),
                       ": poses are solved for joints that turn or slide"));
    }
    Pose X_JZ = Pose::Identity();  // Z is J, turned so that its z axis is the joint's axis
    X_JZ.linear() = BasisFromZ(child.axis_J);
    chain_.joints.push_back({.slides = !turns,
                             .variable = VariableOf(child.variable, of_group, turns),
                             .multiplier = child.is_mimic ? child.multiplier : 1,
                             .offset = child.is_mimic ? child.offset : 0,
                             .X_PJ = X_JL_ * child.X_PJ * X_JZ});
    X_JL_ = X_JZ.inverse(Eigen::Isometry);
    return absl::OkStatus();
  }

  // The variable of the chain for one of the model.
  int VariableOf(int variable, std::ptrdiff_t of_group, bool turns) {
    for (std::size_t k = 0; k < chain_.variables.size(); ++k) {
      if (chain_.variables[k].of_group != of_group) continue;
      chain_.variables[k].turns_endlessly = chain_.variables[k].turns_endlessly && turns;
      return static_cast<int>(k);
    }
    const Variable& limits = model_.variables[static_cast<std::size_t>(variable)];
    const bool is_endless = std::isinf(limits.lower) && std::isinf(limits.upper);
    chain_.variables.push_back({.of_group = static_cast<int>(of_group),
                                .lower = limits.lower,
                                .upper = limits.upper,
                                .turns_endlessly = is_endless && turns});
    return static_cast<int>(chain_.variables.size()) - 1;
  }

  void SetNumbers() {
    const auto add = [&](const Pose& X) {
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 4; ++column) chain_.numbers.push_back(X(row, column));
      }
    };
    for (const IkJoint& joint : chain_.joints) add(joint.X_PJ);
    add(chain_.X_JT);
    chain_.rounded_numbers.assign(chain_.numbers.begin(), chain_.numbers.end());
  }

  const RobotModel& model_;
  const JointGroup& group_;
  IkChain chain_;
  Pose X_JL_ = Pose::Identity();  // the link reached so far, in the frame of the last joint
};

}  // namespace

absl::StatusOr<IkChain> MakeIkChain(const RobotModel& model, const JointGroup& group,
                                    std::span<const double> base, int link, const Pose& X_LT) {
  return ChainMaker(model, group).Make(base, link, X_LT);
}

}  // namespace cwm::collision
