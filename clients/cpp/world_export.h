// A world as a file of another tool.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"

namespace cwm::client {

struct ExportedWorld {
  std::string bytes;
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<std::string> warnings;  // what the format says otherwise, or not at all
};

// DATA_LOSS when less arrives than was announced.
absl::StatusOr<ExportedWorld> ExportWorld(const Connection& connection,
                                          const cwm::v1::ExportWorldRequest& request);

}  // namespace cwm::client
