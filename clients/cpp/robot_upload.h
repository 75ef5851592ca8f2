// Robots to the server.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"

namespace cwm::client {

// A file as the URDF names it.
struct RobotFile {
  std::string name;
  std::string bytes;
};

// Sends the files under the header and waits until the server has replied. Ends early when the
// server refuses something on the way.
absl::StatusOr<cwm::v1::LoadRobotResponse> LoadRobot(const Connection& connection,
                                                     const cwm::v1::LoadRobotHeader& header,
                                                     const std::vector<RobotFile>& files,
                                                     const Progress& progress = {});

}  // namespace cwm::client
