// States asked of a server, over one stream and of one revision of the world.
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
  // The question says of which world, robot and group, at which revision and with which overlay;
  // its rows are filled in. A state is free where its verdict is FREE. The stream must outlive the
  // checker.
  ServerChecker(client::QueryStream& stream, v1::CheckCollisionsRequest question);

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Answer(std::span<const double> rows,
                                                   std::size_t width) override;
  // Adds the verdicts of so many rows.
  absl::Status AskPart(std::span<const double> rows, std::size_t width,
                       std::vector<std::uint8_t>& free);

  client::QueryStream& stream_;
  v1::StreamQueriesRequest request_;
};

}  // namespace cwm::planner
