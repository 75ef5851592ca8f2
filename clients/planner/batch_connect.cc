#include "clients/planner/batch_connect.h"

#include <ompl/base/goals/GoalStates.h>
#include <ompl/geometric/PathGeometric.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace cwm::planner {
namespace {

namespace ob = ompl::base;

// chosen: connections per round that are checked at the fine step; more than one, since the
// shortest may not be free.
constexpr std::size_t kMaxConfirmed = 3;

const JointSpace& SpaceOf(const ob::SpaceInformationPtr& information) {
  return *information->getStateSpace()->as<JointSpace>();
}

}  // namespace

BatchConnect::BatchConnect(const ob::SpaceInformationPtr& information, StateChecker& checker,
                           const ConnectOptions& options)
    : ob::Planner(information, "BatchConnect"),
      space_(SpaceOf(information)),
      options_(options),
      batch_(space_, checker) {
  specs_.recognizedGoal = ob::GOAL_STATES;
}

void BatchConnect::clear() {
  ob::Planner::clear();
  sampler_.reset();
  trees_.clear();
  status_ = absl::OkStatus();
  rounds_ = 0;
}

ob::PlannerStatus BatchConnect::solve(const ob::PlannerTerminationCondition& condition) {
  checkValidity();
  if (trees_.empty()) {  // otherwise a plan that ran out of time continues
    const auto* goals = pdef_->getGoal()->as<ob::GoalStates>();
    goal_count_ = static_cast<int>(goals->getStateCount());
    sampler_ = si_->allocStateSampler();
    trees_.emplace_back(space_, space_.RowOf(pdef_->getStartState(0)));
    trees_.emplace_back(space_, space_.RowOf(goals->getState(0)));
    for (int k = 1; k < goal_count_; ++k) {
      Tree(1).Add(JointTree::kNoParent, space_.RowOf(goals->getState(static_cast<unsigned>(k))));
    }
    if (TryStraightMotion()) return ob::PlannerStatus::EXACT_SOLUTION;
  }
  while (status_.ok() && !condition()) {
    if (const auto path = GrowAndConnect()) {
      Publish(*path);
      return ob::PlannerStatus::EXACT_SOLUTION;
    }
  }
  return status_.ok() ? ob::PlannerStatus::TIMEOUT : ob::PlannerStatus::ABORT;
}

bool BatchConnect::TryStraightMotion() {
  const std::span<const double> start = Tree(0).row(0);
  std::vector<int> goals(static_cast<std::size_t>(goal_count_));
  std::iota(goals.begin(), goals.end(), 0);
  std::ranges::stable_sort(goals, {},
                           [&](int goal) { return space_.Distance(start, Tree(1).row(goal)); });
  for (const double step : {kCoarseStep, kFineStep}) {
    for (const int goal : goals) batch_.Add(start, Tree(1).row(goal), step);
    status_ = batch_.CheckAll();
    if (!status_.ok()) return false;
    std::vector<int> free;
    for (std::size_t k = 0; k < goals.size(); ++k) {
      if (batch_.IsFree(k)) free.push_back(goals[k]);
    }
    if (free.empty()) return false;
    goals = std::move(free);
  }
  const auto row_of = [](std::span<const double> row) { return Row(row.begin(), row.end()); };
  Publish({row_of(start), row_of(Tree(1).row(goals.front()))});
  return true;
}

std::optional<std::vector<Row>> BatchConnect::GrowAndConnect() {
  ++rounds_;
  const int tree = Tree(0).size() <= Tree(1).size() ? 0 : 1;
  const std::vector<int> reached = Grow(tree);
  if (!status_.ok() || reached.empty()) return std::nullopt;
  std::vector<TreeConnection> connections = Connect(tree, reached);
  if (!status_.ok() || connections.empty()) return std::nullopt;
  return Confirm(std::move(connections));
}

std::vector<int> BatchConnect::Grow(int tree) {
  const auto count = static_cast<std::size_t>(options_.samples);
  std::vector<int> nearest(count);
  std::vector<Row> ends(count, Row(space_.width()));
  ob::State* sample = si_->allocState();
  for (std::size_t k = 0; k < count; ++k) {
    sampler_->sampleUniform(sample);
    nearest[k] = Tree(tree).Nearest(space_.RowOf(sample));
    const std::span<const double> from = Tree(tree).row(nearest[k]);
    const double length = space_.Distance(from, space_.RowOf(sample));
    space_.Interpolate(from, space_.RowOf(sample), std::min(1.0, options_.range / length), ends[k]);
    batch_.Add(from, ends[k], kCoarseStep);
  }
  si_->freeState(sample);
  status_ = batch_.CheckAll();
  std::vector<int> reached;
  for (std::size_t k = 0; status_.ok() && k < count; ++k) {
    if (batch_.IsFree(k)) reached.push_back(Tree(tree).Add(nearest[k], ends[k]));
  }
  return reached;
}

std::vector<BatchConnect::TreeConnection> BatchConnect::Connect(int tree,
                                                                const std::vector<int>& reached) {
  JointTree& other = Tree(1 - tree);
  std::vector<int> nearest;
  for (const int node : reached) {
    nearest.push_back(other.Nearest(Tree(tree).row(node)));
    batch_.Add(other.row(nearest.back()), Tree(tree).row(node), kCoarseStep);
  }
  status_ = batch_.CheckAll();
  std::vector<TreeConnection> connections;
  Row row(space_.width());
  for (std::size_t k = 0; status_.ok() && k < reached.size(); ++k) {
    const Row from(other.row(nearest[k]).begin(), other.row(nearest[k]).end());
    const Row to(Tree(tree).row(reached[k]).begin(), Tree(tree).row(reached[k]).end());
    const double length = space_.Distance(from, to);
    const double free_length = batch_.FreeFraction(k) * length;
    int node = nearest[k];
    for (double done = options_.range; done <= free_length && done < length;
         done += options_.range) {
      space_.Interpolate(from, to, done / length, row);
      node = other.Add(node, row);
    }
    if (!batch_.IsFree(k)) continue;
    node = other.Add(node, to);
    TreeConnection& connection = connections.emplace_back();
    connection.nodes[static_cast<std::size_t>(tree)] = reached[k];
    connection.nodes[static_cast<std::size_t>(1 - tree)] = node;
    connection.length = LengthOf(PathOf(connection));
  }
  return connections;
}

std::optional<std::vector<Row>> BatchConnect::Confirm(std::vector<TreeConnection> connections) {
  std::stable_sort(
      connections.begin(), connections.end(),
      [](const TreeConnection& a, const TreeConnection& b) { return a.length < b.length; });
  if (connections.size() > kMaxConfirmed) connections.resize(kMaxConfirmed);
  struct UnconfirmedEdge {
    int tree, node;
  };
  std::vector<UnconfirmedEdge> unconfirmed;
  for (const TreeConnection& connection : connections) {
    for (const int tree : {0, 1}) {
      for (const int node : Tree(tree).PathTo(connection.nodes[static_cast<std::size_t>(tree)])) {
        if (Tree(tree).IsConfirmed(node)) continue;
        Tree(tree).Confirm(node);  // confirmed by this batch, or cut off below
        unconfirmed.push_back({tree, node});
        batch_.Add(Tree(tree).row(Tree(tree).parent(node)), Tree(tree).row(node), kFineStep);
      }
    }
  }
  status_ = batch_.CheckAll();
  if (!status_.ok()) return std::nullopt;
  for (std::size_t k = 0; k < unconfirmed.size(); ++k) {
    if (!batch_.IsFree(k) && Tree(unconfirmed[k].tree).IsAlive(unconfirmed[k].node)) {
      Tree(unconfirmed[k].tree).RemoveSubtree(unconfirmed[k].node);
    }
  }
  for (const TreeConnection& connection : connections) {
    if (IsAlive(connection)) return PathOf(connection);
  }
  return std::nullopt;
}

bool BatchConnect::IsAlive(const TreeConnection& connection) const {
  return Tree(0).IsAlive(connection.nodes[0]) && Tree(1).IsAlive(connection.nodes[1]);
}

std::vector<Row> BatchConnect::PathOf(const TreeConnection& connection) const {
  std::vector<Row> path;
  for (const int node : Tree(0).PathTo(connection.nodes[0])) {
    path.emplace_back(Tree(0).row(node).begin(), Tree(0).row(node).end());
  }
  std::vector<int> back = Tree(1).PathTo(connection.nodes[1]);
  std::reverse(back.begin(), back.end());
  for (std::size_t k = 1; k < back.size(); ++k) {  // the first is the meeting point
    path.emplace_back(Tree(1).row(back[k]).begin(), Tree(1).row(back[k]).end());
  }
  return path;
}

double BatchConnect::LengthOf(const std::vector<Row>& path) const {
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) length += space_.Distance(path[k - 1], path[k]);
  return length;
}

void BatchConnect::Publish(const std::vector<Row>& path) {
  auto solution = std::make_shared<ompl::geometric::PathGeometric>(si_);
  ob::State* state = si_->allocState();
  for (const Row& row : path) {
    std::copy(row.begin(), row.end(), space_.RowOf(state).begin());
    solution->append(state);
  }
  si_->freeState(state);
  pdef_->addSolutionPath(solution, /*approximate=*/false, /*difference=*/0, getName());
}

}  // namespace cwm::planner
