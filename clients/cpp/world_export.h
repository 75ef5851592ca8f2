// A world as a file of another tool.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"

namespace cwm::client {

// Beside the one that was asked for.
struct ExportedFile {
  std::string name;  // relative, of names divided by slashes, none of them "." or ".."
  std::string bytes;
};

struct ExportedWorld {
  std::string bytes;
  std::vector<ExportedFile> files = {};  // that it refers to
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<std::string> warnings;  // what the format says otherwise, or not at all
};

// DATA_LOSS when less arrives than was announced, or files have names that lead elsewhere.
absl::StatusOr<ExportedWorld> ExportWorld(const Connection& connection,
                                          const cwm::v1::ExportWorldRequest& request,
                                          const Progress& progress = {});

}  // namespace cwm::client
