// A planner of OMPL that asks about many motions at once: two trees that grow towards each other.
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
  double range = 1.0;  // the longest motion that a tree grows by (README.md: measured)
  int samples = 16;    // motions a round
};

// RRT-Connect (Kuffner and LaValle 2000) in rounds. Each asks two batches: motions from the smaller
// tree towards random rows, and from the other tree to all rows that were reached so. Motions are
// asked at the coarse step; where the trees meet, those of the whole path at the fine one, and what
// is not free is cut off.
//
// The space is a JointSpace; one start, and a goal that is a state. What the termination condition
// ends, a round at a time, is a TIMEOUT. The same seed and answers make the same path.
class BatchConnect : public ompl::base::Planner {
 public:
  // The checker must outlive the planner; the space information is asked for its space alone.
  BatchConnect(const ompl::base::SpaceInformationPtr& information, StateChecker& checker,
               const ConnectOptions& options);

  ompl::base::PlannerStatus solve(
      const ompl::base::PlannerTerminationCondition& condition) override;
  void clear() override;

  // Why solve was an ABORT: the checker's.
  const absl::Status& status() const { return status_; }
  int rounds() const { return rounds_; }

 private:
  // Nodes of the two trees that are in one place.
  struct Meeting {
    std::array<int, 2> nodes;
    double length = 0;
  };

  bool TryDirectly();
  // The path where the trees have met; nothing: they have not, or the checker failed.
  std::optional<std::vector<Row>> GrowAndConnect();
  std::vector<int> Grow(int tree);
  std::vector<Meeting> Connect(int tree, const std::vector<int>& reached);
  std::optional<std::vector<Row>> Confirm(std::vector<Meeting> meetings);
  std::vector<Row> PathOf(const Meeting& meeting) const;
  bool IsAlive(const Meeting& meeting) const;
  double LengthOf(const std::vector<Row>& path) const;
  void Publish(const std::vector<Row>& path);
  JointTree& Tree(int tree) { return trees_[static_cast<std::size_t>(tree)]; }
  const JointTree& Tree(int tree) const { return trees_[static_cast<std::size_t>(tree)]; }

  const JointSpace& space_;
  const ConnectOptions options_;
  EdgeBatch batch_;
  ompl::base::StateSamplerPtr sampler_;
  std::vector<JointTree> trees_;  // from the start, from the goal
  absl::Status status_;
  int rounds_ = 0;
};

}  // namespace cwm::planner
