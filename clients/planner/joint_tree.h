// A tree of rows that grows from one of them.
#pragma once

#include <span>
#include <vector>

#include "clients/planner/joint_space.h"

namespace cwm::planner {

// Nearest rows are found by looking at all, joint by joint in arrays of their own: a plan has a few
// thousand rows, equal distances are decided by age, and what is cut off is no node at once.
class JointTree {
 public:
  JointTree(const JointSpace& space, std::span<const double> root);

  int size() const { return static_cast<int>(parents_.size()); }  // what was cut off included
  std::span<const double> row(int node) const {
    return {rows_.data() + static_cast<std::size_t>(node) * space_.width(), space_.width()};
  }
  int parent(int node) const { return parents_[static_cast<std::size_t>(node)]; }  // -1: the root
  bool IsAlive(int node) const { return alive_[static_cast<std::size_t>(node)] != 0; }

  int Add(int parent, std::span<const double> row);
  // The node that is nearest; those cut off are not.
  int Nearest(std::span<const double> row) const;
  // Takes away the node, not the root, and all that grew from it.
  void Cut(int node);
  // Whether the motion to the node from its parent has been asked at the fine step; true of the
  // root.
  bool IsConfirmed(int node) const { return confirmed_[static_cast<std::size_t>(node)] != 0; }
  void Confirm(int node) { confirmed_[static_cast<std::size_t>(node)] = 1; }
  // From the root to the node, both included.
  std::vector<int> PathTo(int node) const;

 private:
  const JointSpace& space_;
  std::vector<double> rows_;
  std::vector<std::vector<float>> columns_;  // by joint; of what was cut off, far away
  std::vector<int> parents_;                 // older than their children
  std::vector<char> alive_, confirmed_;
  mutable std::vector<float> sums_;  // room for Nearest
};

}  // namespace cwm::planner
