// The Panda and the scenes of MotionBenchMaker in a running server.
#pragma once

#include <string>
#include <vector>

#include "clients/cpp/connection.h"
#include "tests/benchmarks/panda_problems.h"

namespace cwm::benchmarks {

// Puts the robot "panda" and the objects of the problem into a world of that name.
absl::Status PutPandaProblem(const client::Connection& connection, const PandaProblem& problem,
                             const std::string& world);
// Puts the objects of the problem in place of those of `before`.
absl::Status ReplacePandaProblem(const client::Connection& connection, const PandaProblem& before,
                                 const PandaProblem& problem, const std::string& world);

// A query about states of the group panda_arm.
v1::CheckCollisionsRequest PandaIn(const std::string& world, const std::vector<double>& states,
                                   v1::RobotGeometry geometry);

}  // namespace cwm::benchmarks
