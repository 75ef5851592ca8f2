// Queries with several pairs per row (distances, contacts), computed row by row on several threads.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/query/body_search.h"
#include "collision/query/pair_columns.h"
#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// Finds the pairs of the row at which the search has placed the body. Used by one thread.
class RowFinder {
 public:
  virtual ~RowFinder() = default;
  // The result is void if the search has ended, and valid until the next call.
  virtual const std::vector<FoundPair>& Find() = 0;
};

struct PairQuery {
  const WorldSnapshot& world;
  const QueryBody& body;
  const BodyRows& rows;
  const QueryOptions& options;
  std::stop_token stop;
};

// The rows as states of a robot's joints; nullptr if they are not.
const JointRows* JointRowsOf(const PairQuery& query);

// The pairs of all rows, at most `per_row` each. Runs on the number of threads in the options, each
// with its own search and finder.
absl::StatusOr<PairColumns> FindPairs(
    const PairQuery& query, int per_row,
    const std::function<std::unique_ptr<RowFinder>(BodySearch& search)>& make_finder);

}  // namespace cwm::collision
