// Uploads robots to the server.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"

namespace cwm::client {

// A file under the name that the URDF uses.
struct RobotFile {
  std::string name;
  std::string bytes;
};

// Sends the header and the files and waits for the server's reply. Ends early if the server refuses
// something.
absl::StatusOr<cwm::v1::LoadRobotResponse> LoadRobot(const Connection& connection,
                                                     const cwm::v1::LoadRobotHeader& header,
                                                     const std::vector<RobotFile>& files,
                                                     const Progress& progress = {});

}  // namespace cwm::client
