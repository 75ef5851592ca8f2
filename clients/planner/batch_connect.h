// A planner for OMPL that checks many motions at once: two trees that grow towards each other.
#pragma once

#include <ompl/base/Planner.h>

#include <array>
#include <optional>
#include <vector>

#include "absl/status/status.h"
#include "clients/planner/edge_batch.h"
#include "clients/planner/joint_space.h"
#include "clients/planner/joint_tree.h"
#include "clients/planner/state_checker.h"

namespace cwm::planner {

struct ConnectOptions {
  double range = 1.0;  // chosen: the longest motion by which a tree grows
  int samples = 16;    // motions per round
};

// RRT-Connect (Kuffner and LaValle 2000) in rounds of two batches: motions from the smaller tree
// towards random rows, then from the other tree to all rows reached. Motions are checked at the
// coarse step; where the trees meet, those of the whole path are checked at the fine step, and
// motions that are not free are cut off.
//
// The space must be a JointSpace with one start and goal states, any of which ends the path: the
// other tree has a root at each of them. TIMEOUT if the termination
// condition ended it, which is checked between rounds. The same seed and answers give the same
// path.
class BatchConnect : public ompl::base::Planner {
 public:
  // The checker must outlive the planner; only the space of the space information is used.
  BatchConnect(const ompl::base::SpaceInformationPtr& information, StateChecker& checker,
               const ConnectOptions& options);

  ompl::base::PlannerStatus solve(
      const ompl::base::PlannerTerminationCondition& condition) override;
  void clear() override;

  // The checker's error if solve returned ABORT.
  const absl::Status& status() const { return status_; }
  int rounds() const { return rounds_; }

 private:
  // Nodes of the two trees at the same place.
  struct TreeConnection {
    std::array<int, 2> nodes;
    double length = 0;
  };

  // Publishes the shortest straight motion to a goal that is free.
  bool TryStraightMotion();
  // The path if the trees have met; empty if not, or if the checker failed.
  std::optional<std::vector<Row>> GrowAndConnect();
  std::vector<int> Grow(int tree);
  std::vector<TreeConnection> Connect(int tree, const std::vector<int>& reached);
  std::optional<std::vector<Row>> Confirm(std::vector<TreeConnection> connections);
  std::vector<Row> PathOf(const TreeConnection& connection) const;
  bool IsAlive(const TreeConnection& connection) const;
  double LengthOf(const std::vector<Row>& path) const;
  void Publish(const std::vector<Row>& path);
  JointTree& Tree(int tree) { return trees_[static_cast<std::size_t>(tree)]; }
  const JointTree& Tree(int tree) const { return trees_[static_cast<std::size_t>(tree)]; }

  const JointSpace& space_;
  const ConnectOptions options_;
  EdgeBatch batch_;
  ompl::base::StateSamplerPtr sampler_;
  std::vector<JointTree> trees_;  // the trees from the start and from the goals
  int goal_count_ = 0;            // the first nodes of the second tree
  absl::Status status_;
  int rounds_ = 0;
};

}  // namespace cwm::planner
