// The queries of a benchmark, and how they are sent.
#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/cli/bench/bench_poses.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/query_stream.h"

namespace cwm::cli {

// A batch. Answers are requested as F64 columns.
struct BenchQuery {
  std::string name;  // "distances"
  int rows = 1;
  cwm::v1::StreamQueriesRequest request;
};

// A world that a benchmark queries.
struct QueriedWorld {
  std::string name;
  Region region = kBenchRegion;  // where bodies and points are placed
};

// Queries with a gripper's body, a box of 0.10 x 0.08 x 0.20 m, at random places.
BenchQuery BodyChecks(const QueriedWorld& world, int rows);
BenchQuery Distances(const QueriedWorld& world, int rows);
// Samples at random places.
BenchQuery SampledPoints(const QueriedWorld& world, int rows);
// Random states of all variables within their limits. Unlimited ones turn half a circle to either
// side, or move 1 m; floating joints stay in place.
BenchQuery RobotStates(const QueriedWorld& world, const cwm::v1::Robot& robot, int rows);

// The same query 1 km above the world: what remains is the cost of the call, its messages and, for
// robots, forward kinematics.
BenchQuery InEmptySpace(const QueriedWorld& world,
                        const std::function<BenchQuery(const QueriedWorld&)>& make_query);

// One call each. INTERNAL if not every row was answered.
absl::Status CallUnary(const client::Connection& connection, const BenchQuery& query);
absl::Status CallStream(client::QueryStream& stream, BenchQuery& query);

}  // namespace cwm::cli
