// Checks states with a server over one stream, at one revision of the world.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "clients/cpp/query_stream.h"
#include "clients/planner/state_checker.h"
#include "cwm/v1/query.pb.h"

namespace cwm::planner {

class ServerChecker : public StateChecker {
 public:
  // The query has the world, robot, group, revision and overlay; its rows are filled in. A state
  // is free if its verdict is FREE. The stream must outlive the checker.
  ServerChecker(client::QueryStream& stream, v1::CheckCollisionsRequest query);

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Evaluate(std::span<const double> rows,
                                                     std::size_t width) override;
  // Appends the verdicts of the given rows.
  absl::Status EvaluatePart(std::span<const double> rows, std::size_t width,
                            std::vector<std::uint8_t>& free);

  client::QueryStream& stream_;
  v1::StreamQueriesRequest request_;
};

}  // namespace cwm::planner
