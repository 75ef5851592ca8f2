#include "clients/planner/joint_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cwm::planner {
namespace {

constexpr float kFullTurn_rad = 2 * std::numbers::pi_v<float>;
constexpr float kFarAway = 1e15f;  // its square is finite

void AddSquares(const std::vector<float>& column, float value, std::vector<float>& sums) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    const float difference = column[i] - value;
    sums[i] += difference * difference;
  }
}

// For rows within one turn.
void AddSquaresOfShortWay(const std::vector<float>& column, float value, std::vector<float>& sums) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    const float way = std::abs(column[i] - value);
    const float difference = std::min(way, std::abs(kFullTurn_rad - way));
    sums[i] += difference * difference;
  }
}

}  // namespace

JointTree::JointTree(const JointSpace& space, std::span<const double> root)
    : space_(space), columns_(space.width()) {
  Add(kNoParent, root);
}

int JointTree::Add(int parent, std::span<const double> row) {
  rows_.insert(rows_.end(), row.begin(), row.end());
  for (std::size_t j = 0; j < space_.width(); ++j) {
    const bool turns = space_.joints()[j].kind == Joint::Kind::kContinuous;
    columns_[j].push_back(
        static_cast<float>(turns ? std::remainder(row[j], 2 * std::numbers::pi) : row[j]));
  }
  parents_.push_back(parent);
  alive_.push_back(1);
  confirmed_.push_back(parent == kNoParent ? 1 : 0);
  return size() - 1;
}

int JointTree::Nearest(std::span<const double> row) const {
  sums_.assign(parents_.size(), 0);
  for (std::size_t j = 0; j < space_.width(); ++j) {
    if (space_.joints()[j].kind == Joint::Kind::kContinuous) {
      AddSquaresOfShortWay(columns_[j],
                           static_cast<float>(std::remainder(row[j], 2 * std::numbers::pi)), sums_);
    } else {
      AddSquares(columns_[j], static_cast<float>(row[j]), sums_);
    }
  }
  return static_cast<int>(std::min_element(sums_.begin(), sums_.end()) - sums_.begin());
}

void JointTree::RemoveSubtree(int node) {
  alive_[static_cast<std::size_t>(node)] = 0;
  for (int child = node + 1; child < size(); ++child) {
    if (!IsAlive(parent(child))) alive_[static_cast<std::size_t>(child)] = 0;
  }
  for (int i = node; i < size(); ++i) {
    if (IsAlive(i)) continue;
    for (std::vector<float>& column : columns_) column[static_cast<std::size_t>(i)] = kFarAway;
  }
}

std::vector<int> JointTree::PathTo(int node) const {
  std::vector<int> path;
  for (int i = node; i != kNoParent; i = parent(i)) path.push_back(i);
  std::reverse(path.begin(), path.end());
  return path;
}

}  // namespace cwm::planner
