// All contacts between the objects and robots of a world, without a subject.
#pragma once

#include <cstdint>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/query/query.h"

namespace cwm::collision {

// One entry per pair of parts, deepest first; ties by the names of the two, then by their parts.
// `a` is the object or robot whose name comes first, and of a self pair the lower part.
struct WorldContactColumns {
  std::vector<std::int32_t> object_a, object_b;  // WorldSnapshot::ObstacleAt; equal for self pairs
  std::vector<std::int32_t> part_a, part_b;
  std::vector<double> distance_m;
  std::vector<double> point_a, point_b;  // x y z, on either part, world frame
  std::vector<double> normal;            // x y z, unit, from a to b
  std::vector<Accuracy> accuracy;
  std::vector<double> bound_m;
  bool is_complete = true;  // false: max_contacts or the deadline ended the list
};

// The pairs of parts whose distance is less than their margin (query.h), each by its nearest
// points, at most QueryOptions::max_contacts of them, the deepest. Objects and robots are at their
// poses and states. Their pairs are those of queries about each of them, with these differences: an
// object and its support have the margin -support_tolerance_m whichever of them is asked about. The
// self pairs of robots count, with those that rules check. An attached object is not tested against
// the link that carries it, its touch links and what else that link carries. QueryOptions::only
// keeps the pairs of which at least one member is named.
//
// Walks the tree of bounds once per object. Errors are those of the queries about bodies.
absl::StatusOr<WorldContactColumns> GetWorldContacts(const WorldSnapshot& world,
                                                     const QueryOptions& options,
                                                     std::stop_token stop = {});

}  // namespace cwm::collision
