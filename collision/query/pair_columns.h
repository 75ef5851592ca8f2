// Collects the pairs of a row and writes them into columns.
#pragma once

#include <algorithm>
#include <vector>

#include "collision/query/body_search.h"
#include "collision/query/object_ranks.h"
#include "collision/query/query.h"

namespace cwm::collision {

struct FoundPair {
  PairDistance answer;
  PairId id;
  bool is_tied = false;  // another pair that the answer stands for is as near

  // Nearest (deepest) first; ties by object name, then part.
  friend bool operator<(const FoundPair& a, const FoundPair& b) {
    if (a.answer.distance_m != b.answer.distance_m) {
      return a.answer.distance_m < b.answer.distance_m;
    }
    return a.id < b.id;
  }
};

// Keeps the best `capacity` pairs of a row, sorted.
class BestPairs {
 public:
  explicit BestPairs(int capacity) : capacity_(static_cast<std::size_t>(std::max(0, capacity))) {}

  void Clear() { pairs_.clear(); }
  bool is_full() const { return pairs_.size() >= capacity_; }
  // The largest distance at which a further pair can still be added.
  double Limit_m(double otherwise_m) const {
    if (!is_full()) return otherwise_m;
    return pairs_.empty() ? -std::numeric_limits<double>::infinity()
                          : pairs_.back().answer.distance_m;
  }
  void Add(const FoundPair& pair) {
    if (is_full()) {
      if (pairs_.empty() || !(pair < pairs_.back())) return;
      pairs_.pop_back();
    }
    pairs_.insert(std::upper_bound(pairs_.begin(), pairs_.end(), pair), pair);
  }
  const std::vector<FoundPair>& pairs() const { return pairs_; }

 private:
  std::size_t capacity_;
  std::vector<FoundPair> pairs_;
};

void Reserve(PairColumns& columns, std::size_t rows, std::size_t pairs_per_row);

// Weakens every label that is better than `best`.
void LimitAccuracy(PairColumns& columns, Accuracy best);

// Appends the pairs of a finished row.
void AppendRow(PairColumns& columns, const std::vector<FoundPair>& pairs, ObjectRanks& ranks);

// Concatenates pieces of a batch in order until `completed` rows are reached. All pieces used are
// whole, except possibly the last; the pieces after it are dropped.
PairColumns Joined(std::vector<PairColumns> pieces, std::size_t completed);

}  // namespace cwm::collision
