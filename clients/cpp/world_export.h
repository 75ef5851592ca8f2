// Exports a world as a file of another tool.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"

namespace cwm::client {

// A file besides the requested one.
struct ExportedFile {
  std::string name;  // relative path with slashes, without "." or ".."
  std::string bytes;
};

struct ExportedWorld {
  std::string bytes;
  std::vector<ExportedFile> files = {};  // the files that it refers to
  std::string world_uid;
  std::int64_t revision = 0;
  std::vector<std::string> warnings;  // what the format expresses differently, or not at all
};

// DATA_LOSS if fewer bytes arrive than announced, or if a file's name leads elsewhere.
absl::StatusOr<ExportedWorld> ExportWorld(const Connection& connection,
                                          const cwm::v1::ExportWorldRequest& request,
                                          const Progress& progress = {});

}  // namespace cwm::client
