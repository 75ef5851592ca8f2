// What a benchmark asks, and how it travels.
#pragma once

#include <functional>
#include <string>

#include "absl/status/statusor.h"
#include "clients/cli/bench/bench_poses.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/query_stream.h"

namespace cwm::cli {

// A batch. Answers are asked for as F64 columns.
struct Question {
  std::string of;  // "distances"
  int rows = 1;
  cwm::v1::StreamQueriesRequest request;
};

// What is asked of which world.
struct AskedWorld {
  std::string name;
  Region region = kBenchRegion;  // where bodies and points are asked
};

// Of the body of a gripper, a box of 0.10 x 0.08 x 0.20 m, at random places.
Question BodyChecks(const AskedWorld& world, int rows);
Question Distances(const AskedWorld& world, int rows);
// At random places.
Question SampledPoints(const AskedWorld& world, int rows);
// Random states within its limits, of all its variables; what has none turns half a circle to
// either side, or moves 1 m; what floats stays.
Question RobotStates(const AskedWorld& world, const cwm::v1::Robot& robot, int rows);

// What `ask` asks, 1 km above the world: what is left is the call, its messages and, of robots, where
// their links are.
Question OfNothing(const AskedWorld& world, const std::function<Question(const AskedWorld&)>& ask);

// One call each. INTERNAL when not every row is answered.
absl::Status AskUnary(const client::Connection& connection, const Question& question);
absl::Status AskStream(client::QueryStream& stream, Question& question);

}  // namespace cwm::cli
