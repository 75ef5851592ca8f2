// States asked of a server, over one stream and of one revision of the world.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "clients/cpp/connection.h"
#include "clients/planner/state_checker.h"
#include "cwm/v1/query.pb.h"

namespace cwm::planner {

class ServerChecker : public StateChecker {
 public:
  // The question says of which world, robot and group, at which revision and with which overlay;
  // its rows are filled in. A state is free where its verdict is FREE. The connection must outlive
  // the checker; no deadline: each batch is answered in milliseconds, and a lost server ends the
  // stream.
  ServerChecker(const client::Connection& connection, v1::CheckCollisionsRequest question);
  ~ServerChecker() override;
  ServerChecker(const ServerChecker&) = delete;
  ServerChecker& operator=(const ServerChecker&) = delete;

 private:
  absl::StatusOr<std::vector<std::uint8_t>> Answer(std::span<const double> rows,
                                                   std::size_t width) override;
  // Adds the verdicts of so many rows.
  absl::Status AskPart(std::span<const double> rows, std::vector<std::uint8_t>& free);
  absl::Status EndOfStream();

  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::StreamQueriesRequest, v1::StreamQueriesResponse>>
      stream_;
  v1::StreamQueriesRequest request_;
};

}  // namespace cwm::planner
