#include "collision/query/robot_body.h"

#include <algorithm>
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

using PartsOfLink = std::vector<std::vector<std::int32_t>>;

PartsOfLink PartsOfLinks(const QueryBody& body) {
  PartsOfLink parts(static_cast<std::size_t>(body.frame_count));
  for (std::size_t part = 0; part < body.frame_of_part.size(); ++part) {
    const int frame = body.frame_of_part[part];
    if (frame >= body.frame_count) break;  // parts of attached objects come last
    parts[static_cast<std::size_t>(frame)].push_back(static_cast<std::int32_t>(part));
  }
  return parts;
}

// The own parts of a body by link, without those that only contain others if `without_containing`,
// else without those that are there for self pairs alone.
PartsOfLink PartsOfLinks(const QueryBody& body, bool without_containing) {
  PartsOfLink parts = PartsOfLinks(body);
  for (std::vector<std::int32_t>& of_link : parts) {
    std::erase_if(of_link, [&](std::int32_t part) {
      return without_containing ? body.IsContaining(part) : body.IsSelfOnly(part);
    });
  }
  return parts;
}

void AddSelfPairs(const PartsOfLink& parts, const LinkPair& links, QueryBody& body) {
  for (std::int32_t a : parts[static_cast<std::size_t>(links.first)]) {
    for (std::int32_t b : parts[static_cast<std::size_t>(links.second)]) {
      body.self_pairs.push_back({a, b});
    }
  }
}

// Sets the paddings of all frames; none if all are 0.
void SetFramePaddings(std::vector<double> paddings_m, QueryBody& body) {
  const bool has_padding = std::ranges::any_of(paddings_m, [](double each) { return each > 0; });
  body.frame_padding_m = has_padding ? std::move(paddings_m) : std::vector<double>();
}

// The pairs of the robot's links that the rules check although the robot does not.
std::vector<LinkPair> UncheckedPairsOf(const RobotModel& model, std::string_view name,
                                       const PairRules& rules) {
  std::vector<LinkPair> pairs;
  for (const PairRule& rule : rules) {
    if (!rule.check || rule.pair.a.name != name) continue;
    const std::optional<int> a = model.FindLink(rule.pair.a.link);
    const std::optional<int> b = model.FindLink(rule.pair.b.link);
    if (!a || !b) continue;  // the rule is about links of another model of this name
    const bool in_order = model.links[static_cast<std::size_t>(*a)].urdf_index <
                          model.links[static_cast<std::size_t>(*b)].urdf_index;
    pairs.push_back(in_order ? LinkPair{*a, *b} : LinkPair{*b, *a});
  }
  if (pairs.empty()) return pairs;
  const auto order = [](const LinkPair& x, const LinkPair& y) {
    return std::pair(x.first, x.second) < std::pair(y.first, y.second);
  };
  std::ranges::sort(pairs, order);
  std::vector<bool> is_checked(pairs.size(), false);
  for (const LinkPair& pair : model.self_pairs) {
    const auto at = std::ranges::lower_bound(pairs, pair, order);
    if (at != pairs.end() && *at == pair) {
      is_checked[static_cast<std::size_t>(at - pairs.begin())] = true;
    }
  }
  std::size_t k = 0;
  std::erase_if(pairs, [&](const LinkPair&) { return is_checked[k++]; });
  return pairs;
}

// Sets the frames, one per link, their paddings and the self pairs of a body that already has its
// parts.
void SetScope(const RobotGeometry& robot, RobotScope scope, QueryBody& body) {
  const RobotModel& model = *robot.model;
  body.robot = robot.model;
  body.programs = robot.programs;
  body.frame_count = static_cast<int>(model.links.size());
  body.tests_world = scope != RobotScope::kSelf;
  std::vector<double> paddings_m;
  for (const ModelLink& link : model.links) paddings_m.push_back(link.padding_m);
  SetFramePaddings(std::move(paddings_m), body);
  if (scope == RobotScope::kWorld) return;
  const PartsOfLink parts = PartsOfLinks(body);
  for (const LinkPair& pair : model.self_pairs) AddSelfPairs(parts, pair, body);
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

QueryBody BodyFromBounds(const RobotGeometry& robot, const PreparedBounds& bounds,
                         RobotScope scope) {
  QueryBody body{.geometry = bounds.geometry, .frame_of_part = bounds.link_of_part};
  body.best_accuracy = Accuracy::kDegraded;
  body.containing_count = bounds.sphere_count;
  SetScope(robot, scope, body);
  if (scope == RobotScope::kWorld) return body;
  body.self_pairs.clear();
  const PartsOfLink spheres = PartsOfLinks(body, false), exact = PartsOfLinks(body, true);
  for (const LinkPair& pair : robot.model->self_pairs) {
    const bool is_tight = std::ranges::find(bounds.tight_pairs, pair) != bounds.tight_pairs.end();
    AddSelfPairs(is_tight ? exact : spheres, pair, body);
  }
  return body;
}

void SetPaddings(const LinkValues& paddings_m, QueryBody& body) {
  std::vector<double> of_frames;
  for (int link = 0; link < body.frame_count; ++link) {
    const std::string& name = body.robot->links[static_cast<std::size_t>(link)].name;
    of_frames.push_back(ValueOf(paddings_m, name, body.PaddingOf_m(link)));
  }
  SetFramePaddings(std::move(of_frames), body);
}

QueryBody WithCheckedPairs(QueryBody body, const PairRules& rules, RobotScope scope) {
  if (scope == RobotScope::kWorld) return body;
  const std::vector<LinkPair> pairs = UncheckedPairsOf(*body.robot, body.self, rules);
  if (pairs.empty()) return body;
  const PartsOfLink parts = PartsOfLinks(body, false);
  for (const LinkPair& pair : pairs) AddSelfPairs(parts, pair, body);
  return body;
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
