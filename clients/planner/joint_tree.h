// A tree of rows that grows from its root, or from several.
#pragma once

#include <span>
#include <vector>

#include "clients/planner/joint_space.h"

namespace cwm::planner {

// The nearest row is found by a linear search over one array per joint: a plan has a few thousand
// rows, ties are resolved by age, and a removed node is excluded at once.
class JointTree {
 public:
  static constexpr int kNoParent = -1;  // of a root

  JointTree(const JointSpace& space, std::span<const double> root);

  int size() const { return static_cast<int>(parents_.size()); }  // including removed nodes
  std::span<const double> row(int node) const {
    return {rows_.data() + static_cast<std::size_t>(node) * space_.width(), space_.width()};
  }
  int parent(int node) const {
    return parents_[static_cast<std::size_t>(node)];
  }  // kNoParent: a root
  bool IsAlive(int node) const { return alive_[static_cast<std::size_t>(node)] != 0; }

  // Further roots are added before other nodes.
  int Add(int parent, std::span<const double> row);
  // The nearest node that was not removed.
  int Nearest(std::span<const double> row) const;
  // Removes the node, which must not be a root, and its whole subtree.
  void RemoveSubtree(int node);
  // True if the motion to the node from its parent was checked at the fine step; always true for
  // a root.
  bool IsConfirmed(int node) const { return confirmed_[static_cast<std::size_t>(node)] != 0; }
  void Confirm(int node) { confirmed_[static_cast<std::size_t>(node)] = 1; }
  // The nodes from its root to the node, both included.
  std::vector<int> PathTo(int node) const;

 private:
  const JointSpace& space_;
  std::vector<double> rows_;
  std::vector<std::vector<float>> columns_;  // per joint; far away for removed nodes
  std::vector<int> parents_;                 // parents have smaller indices than their children
  std::vector<char> alive_, confirmed_;
  mutable std::vector<float> sums_;  // scratch memory of Nearest
};

}  // namespace cwm::planner
