// The pair rules for any two obstacles of a world, for queries without a subject.
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "collision/query/pair_rule_lookup.h"
#include "collision/query/query.h"

namespace cwm::collision {

// The combined rules for the parts of two obstacles. Empty if no rule applies to them.
class ObstaclePairTable {
 public:
  ObstaclePairTable() = default;
  ObstaclePairTable(std::size_t rows, std::size_t columns)
      : columns_(columns), rules_(rows * columns) {}

  bool empty() const { return rules_.empty(); }
  // The rules for a link of the first obstacle and one of the second; 0 for an object.
  const CombinedRule& At(int first, int second) const {
    return rules_[static_cast<std::size_t>(first) * columns_ + static_cast<std::size_t>(second)];
  }
  CombinedRule& At(int first, int second) {
    return rules_[static_cast<std::size_t>(first) * columns_ + static_cast<std::size_t>(second)];
  }

 private:
  std::size_t columns_ = 0;
  std::vector<CombinedRule> rules_;  // by link of the first obstacle, then of the second
};

// Immutable. Refers to the world and to `ignore_pairs`.
class ObstaclePairRules {
 public:
  ObstaclePairRules(const WorldSnapshot& world, std::span<const PairRule> ignored);

  // The rules for two obstacles, or for the links of one robot if they are the same.
  ObstaclePairTable Of(const Obstacle& first, const Obstacle& second) const;
  // The largest margin that a rule sets; 0 if none does.
  double max_margin_m() const { return max_margin_m_; }

 private:
  using Names = std::pair<std::string_view, std::string_view>;  // ordered

  void Add(const PairRule& rule);

  absl::flat_hash_map<Names, std::vector<const PairRule*>> rules_;
  double max_margin_m_ = 0;
};

}  // namespace cwm::collision
