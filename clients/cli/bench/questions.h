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
struct Question {
  std::string of;  // "distances"
  int rows = 1;
  cwm::v1::StreamQueriesRequest request;
};

// The queried world.
struct AskedWorld {
  std::string name;
  Region region = kBenchRegion;  // where bodies and points are placed
};

// Queries with a gripper's body, a box of 0.10 x 0.08 x 0.20 m, at random places.
Question BodyChecks(const AskedWorld& world, int rows);
Question Distances(const AskedWorld& world, int rows);
// Samples at random places.
Question SampledPoints(const AskedWorld& world, int rows);
// Random states of all variables within their limits. Unlimited ones turn half a circle to either
// side, or move 1 m; floating joints stay in place.
Question RobotStates(const AskedWorld& world, const cwm::v1::Robot& robot, int rows);

// The query of `ask` moved 1 km above the world: what remains is the cost of the call, its messages
// and, for robots, forward kinematics.
Question OfNothing(const AskedWorld& world, const std::function<Question(const AskedWorld&)>& ask);

// One call each. INTERNAL if not every row was answered.
absl::Status AskUnary(const client::Connection& connection, const Question& question);
absl::Status AskStream(client::QueryStream& stream, Question& question);

}  // namespace cwm::cli
