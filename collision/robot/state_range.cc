#include "collision/robot/state_range.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "collision/geometry/validation.h"
#include "collision/robot/kinematics.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

bool IsInRange(double value) { return std::abs(value) <= kMaxCoordinate_m; }  // not NaN

bool IsInRange(const Vector3& p_WL) {
  return IsInRange(p_WL.x()) && IsInRange(p_WL.y()) && IsInRange(p_WL.z());
}

// By link: its largest distance from the root while nothing slides.
std::vector<double> FixedReaches_m(const RobotModel& model) {
  // The path to a link: the reach of the nearest moving link above it, and the pose from there.
  struct PathToLink {
    double reach_m = 0;
    Pose X_ML = Pose::Identity();
  };
  std::vector<PathToLink> paths(model.links.size());
  std::vector<double> reaches_m(model.links.size(), 0);
  for (std::size_t i = 1; i < model.links.size(); ++i) {
    const ModelLink& link = model.links[i];
    const PathToLink& above = paths[static_cast<std::size_t>(link.parent)];
    const Pose X_ML = above.X_ML * link.X_PJ;
    reaches_m[i] = above.reach_m + X_ML.translation().norm();
    if (link.kind == JointKind::kFixed) {
      paths[i] = {above.reach_m, X_ML};
    } else {
      if (link.kind == JointKind::kPrismatic) reaches_m[i] += std::abs(link.offset);
      paths[i].reach_m = reaches_m[i];
    }
  }
  return reaches_m;
}

bool HasSeveralVariables(JointKind kind) {
  return kind == JointKind::kPlanar || kind == JointKind::kFloating;
}

// The effect of a variable on the reach.
struct Effect {
  double slide = 0;
  int axes = 0;
  double farthest = std::numeric_limits<double>::infinity();
};

std::vector<Effect> EffectsOf(const RobotModel& model) {
  std::vector<Effect> effects(model.variables.size());
  for (const ModelLink& link : model.links) {
    const auto first = static_cast<std::size_t>(link.variable);
    if (HasSeveralVariables(link.kind)) {
      const std::size_t axes = link.kind == JointKind::kPlanar ? 2 : 3;
      for (std::size_t k = 0; k < axes; ++k) effects[first + k] = {.slide = 1, .axes = 1};
    }
    if (link.kind == JointKind::kPrismatic) {
      effects[first].slide += std::abs(link.multiplier);
      ++effects[first].axes;
    }
    if (!link.is_mimic) continue;
    double& farthest = effects[first].farthest;
    const double room = kMaxCoordinate_m - std::abs(link.offset);
    if (room / std::abs(link.multiplier) < farthest) farthest = room / std::abs(link.multiplier);
  }
  return effects;
}

}  // namespace

absl::Status CheckReach(const RobotModel& model) {
  const std::vector<double> reaches_m = FixedReaches_m(model);
  for (std::size_t i = 0; i < reaches_m.size(); ++i) {
    if (IsInRange(reaches_m[i])) continue;
    return FaultAt(
        absl::StrCat("urdf: link ", Quoted(model.links[i].name)),
        absl::StrCat("may be ", reaches_m[i],
                     " m from the root, the origins of the joints between them added up, "
                     "must be at most ",
                     kMaxCoordinate_m, " m"));
  }
  return absl::OkStatus();
}

StateRange::StateRange(const RobotModel& model, const JointGroup& group, const Pose& X_WB,
                       std::vector<double> base)
    : model_(model), group_(group), X_WB_(X_WB), base_(std::move(base)) {
  const std::vector<double> reaches_m = FixedReaches_m(model);
  rest_m_ = X_WB.translation().norm() + *std::max_element(reaches_m.begin(), reaches_m.end());
  std::vector<Effect> effects = EffectsOf(model);
  for (std::size_t k = 0; k < group.variables.size(); ++k) {
    Effect& effect = effects[static_cast<std::size_t>(group.variables[k])];
    const bool matters = effect.slide > 0 || std::isfinite(effect.farthest);
    if (matters) columns_.push_back({k, effect.slide, effect.farthest});
    slides_ += effect.axes;
    effect = {};  // the base does not count for the group's variables
  }
  for (std::size_t v = 0; v < effects.size(); ++v) {
    if (effects[v].slide > 0) rest_m_ += effects[v].slide * std::abs(base_[v]);
    if (!(std::abs(base_[v]) <= effects[v].farthest)) {
      rest_m_ = std::numeric_limits<double>::infinity();
    }
  }
}

bool StateRange::IsCertainlyInside(std::span<const double> row) const {
  double reach_m = rest_m_;
  for (const Column& column : columns_) {
    const double value = std::abs(row[column.at]);
    if (!(value <= column.farthest)) return false;
    reach_m += column.slide * value;
  }
  return IsInRange(reach_m);
}

std::optional<std::string> StateRange::FaultOf(std::span<const double> row) const {
  if (IsCertainlyInside(row)) return std::nullopt;
  std::vector<double> state = base_;
  for (std::size_t k = 0; k < row.size(); ++k) {
    state[static_cast<std::size_t>(group_.variables[k])] = row[k];
  }
  std::vector<Pose> X_WL(model_.links.size());
  LinkPoses(model_, X_WB_, state, X_WL);
  for (std::size_t i = 0; i < X_WL.size(); ++i) {
    const ModelLink& link = model_.links[i];
    if (link.is_mimic) {
      const double value =
          link.multiplier * state[static_cast<std::size_t>(link.variable)] + link.offset;
      if (!IsInRange(value)) {
        return absl::StrCat("puts joint ", Quoted(link.joint), ", which follows another, at ",
                            value, ", must be at most ", kMaxCoordinate_m, " in magnitude");
      }
    }
    const Vector3 p_WL = X_WL[i].translation();
    if (IsInRange(p_WL) && X_WL[i].linear().allFinite()) continue;
    return absl::StrCat("puts link ", Quoted(link.name), " at (", p_WL.x(), ", ", p_WL.y(), ", ",
                        p_WL.z(), "), must be within ", kMaxCoordinate_m,
                        " m of the world's origin along each axis");
  }
  return std::nullopt;
}

std::optional<std::string> StateFault(const RobotModel& model, const Pose& X_WB,
                                      std::span<const double> state) {
  return StateRange(model, model.all, X_WB, {state.begin(), state.end()}).FaultOf(state);
}

}  // namespace cwm::collision
