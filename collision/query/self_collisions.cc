#include "collision/query/self_collisions.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "collision/broadphase/bounds_tree.h"
#include "collision/engines/exact_engine.h"
#include "collision/geometry/quick_bounds.h"
#include "collision/robot/kinematics.h"

namespace cwm::collision {
namespace {

// chosen: at some tens of nanoseconds for a step, sampled and named states take at most some 30 ms
// each.
constexpr std::size_t kMaxSteps = 1'000'000;
// measured: a test of two primitives takes a microsecond, of two hulls a few; the kernels count
// what they do with triangles by themselves.
constexpr std::size_t kStepsPerTest = 64, kStepsPerLink = 4;

// Ends after a number of steps, or with another counter.
class StepLimit final : public WorkCounter {
 public:
  explicit StepLimit(WorkCounter* other) : other_(other) {}

  void Refill() { left_ = kMaxSteps; }

  bool MustEndAfter(std::size_t steps) override {
    left_ -= std::min(left_, steps);
    return left_ == 0 || MustEnd(other_, steps);
  }
  bool MustEndNow() override { return left_ == 0 || (other_ != nullptr && other_->MustEndNow()); }

 private:
  std::size_t left_ = kMaxSteps;
  WorkCounter* const other_;
};

class UniformStates {
 public:
  explicit UniformStates(const RobotModel& model) : model_(model) {}

  std::vector<double> Next() {
    std::vector<double> state;
    for (const Variable& variable : model_.variables) {
      const JointKind kind = model_.links[static_cast<std::size_t>(variable.link)].kind;
      const double reach = kind == JointKind::kPrismatic ? 1 : std::numbers::pi;
      // Quaternions are normalised by the kinematics, so any of them will do.
      const double lower = std::isfinite(variable.lower) ? variable.lower : -reach;
      const double upper = std::isfinite(variable.upper) ? variable.upper : reach;
      state.push_back(lower + Number() * (upper - lower));
    }
    return state;
  }

 private:
  // In [0, 1). The standard fixes the generator, but not the distributions.
  double Number() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  const RobotModel& model_;
  std::mt19937_64 random_;
};

// The parts of a robot in one state, placed when they are needed.
class PlacedRobot {
 public:
  PlacedRobot(const RobotGeometry& robot, WorkCounter& work)
      : robot_(robot), work_(work), X_WL_(robot.model->links.size()) {
    parts_of_link_.resize(X_WL_.size());
    for (std::size_t part = 0; part < robot.link_of_part.size(); ++part) {
      parts_of_link_[static_cast<std::size_t>(robot.link_of_part[part])].push_back(part);
    }
    parts_.resize(robot.link_of_part.size());
    placed_at_.resize(X_WL_.size(), 0);
  }

  // False if the work ran out.
  bool Place(std::span<const double> state) {
    LinkPoses(*robot_.model, Pose::Identity(), state, X_WL_);
    ++placement_;
    return !work_.MustEndAfter(kStepsPerLink * X_WL_.size());
  }

  // False if the work ran out.
  bool Collide(const LinkPair& links) {
    PlaceParts(links.first);
    PlaceParts(links.second);
    for (const std::size_t a : PartsOf(links.first)) {
      for (const std::size_t b : PartsOf(links.second)) {
        if (PartsCollide(a, b)) return true;
        if (HasEnded(&work_)) return false;
      }
    }
    return false;
  }

 private:
  struct BoxedPart {
    Pose X_WP;
    Aabb bounds_W;
  };

  const std::vector<std::size_t>& PartsOf(int link) const {
    return parts_of_link_[static_cast<std::size_t>(link)];
  }

  void PlaceParts(int link) {
    int& placed_at = placed_at_[static_cast<std::size_t>(link)];
    if (placed_at == placement_) return;
    placed_at = placement_;
    const Pose& X_WL = X_WL_[static_cast<std::size_t>(link)];
    for (const std::size_t k : PartsOf(link)) {
      const PreparedPart& part = robot_.geometry->parts[k];
      parts_[k] = {X_WL * part.X_OP, BoundsOfBox(part.bounds_O, X_WL)};
    }
  }

  bool PartsCollide(std::size_t a, std::size_t b) {
    if (work_.MustEndAfter(1)) return false;
    if (SquaredDistance_m2(parts_[a].bounds_W, parts_[b].bounds_W) > 0) return false;
    const PlacedGeometry first = GeometryOf(a), second = GeometryOf(b);
    if (work_.MustEndAfter(kStepsPerTest)) return false;
    if (LowerBound_m(first, second).value_or(0) > 0) return false;  // the hulls are apart
    return GetEngine(EngineKind::kExact).Collides(first, second, &work_) && !HasEnded(&work_);
  }

  PlacedGeometry GeometryOf(std::size_t k) const {
    const PreparedPart& part = robot_.geometry->parts[k];
    return {KindOf(part.shape), *part.engines[static_cast<int>(EngineKind::kExact)],
            parts_[k].X_WP};
  }

  const RobotGeometry& robot_;
  WorkCounter& work_;
  std::vector<std::vector<std::size_t>> parts_of_link_;
  std::vector<Pose> X_WL_;
  std::vector<BoxedPart> parts_;
  std::vector<int> placed_at_;  // by link: the placement at which its parts were placed
  int placement_ = 0;
};

std::vector<LinkPair> FindAlwaysColliding(const RobotModel& model, PlacedRobot& robot,
                                          WorkCounter& work) {
  std::vector<LinkPair> pairs = model.self_pairs;
  UniformStates states(model);
  for (int k = 0; k < kSampledStates && !pairs.empty(); ++k) {
    if (!robot.Place(states.Next())) return {};
    std::erase_if(pairs, [&](const LinkPair& pair) { return !robot.Collide(pair); });
    if (HasEnded(&work)) return {};
  }
  return pairs;
}

// The pairs that are not among `some`, which has the same order.
std::vector<LinkPair> Without(const std::vector<LinkPair>& pairs,
                              const std::vector<LinkPair>& some) {
  std::vector<LinkPair> others;
  auto next = some.begin();
  for (const LinkPair& pair : pairs) {
    if (next != some.end() && *next == pair) {
      ++next;
    } else {
      others.push_back(pair);
    }
  }
  return others;
}

// By link: true if a variable of the group moves the joint above it.
std::vector<bool> JointsOf(const RobotModel& model, const JointGroup& group) {
  std::vector<bool> is_of_group(model.links.size(), false);
  for (std::size_t link = 1; link < model.links.size(); ++link) {
    const ModelLink& each = model.links[link];
    is_of_group[link] = each.kind != JointKind::kFixed &&
                        std::ranges::binary_search(group.variables, each.variable);
  }
  return is_of_group;
}

// True if one of the joints moves the links relative to each other.
bool MoveApart(const RobotModel& model, const std::vector<bool>& joints, LinkPair links) {
  while (links.first != links.second) {  // parents have lower indices
    int& later = links.first > links.second ? links.first : links.second;
    if (joints[static_cast<std::size_t>(later)]) return true;
    later = model.links[static_cast<std::size_t>(later)].parent;
  }
  return false;
}

std::vector<double> StateOf(const RobotModel& model, const NamedState& named) {
  std::vector<double> state = DefaultVariables(model);
  for (std::size_t k = 0; k < named.variables.size(); ++k) {
    state[static_cast<std::size_t>(named.variables[k])] = named.values[k];
  }
  return state;
}

}  // namespace

std::optional<SelfCollisions> FindSelfCollisions(const RobotGeometry& robot,
                                                 std::span<const double> initial_state,
                                                 WorkCounter* work) {
  const RobotModel& model = *robot.model;
  StepLimit limit(work);
  PlacedRobot placed(robot, limit);
  SelfCollisions found{.always = FindAlwaysColliding(model, placed, limit), .states = {}};
  limit.Refill();
  const std::vector<LinkPair> others = Without(model.self_pairs, found.always);
  const auto test = [&](std::span<const double> state, const JointGroup& group,
                        const std::string& name) {
    if (!placed.Place(state)) return;
    const std::vector<bool> joints = JointsOf(model, group);
    const auto at = std::ranges::find_if(others, [&](const LinkPair& pair) {
      return MoveApart(model, joints, pair) && placed.Collide(pair);
    });
    if (at != others.end()) found.states.push_back({group.name, name, *at});
  };
  test(initial_state, model.all, "");
  for (const JointGroup& group : model.groups) {
    for (const NamedState& state : group.states) test(StateOf(model, state), group, state.name);
  }
  if (HasEnded(work)) return std::nullopt;
  return found;
}

}  // namespace cwm::collision
