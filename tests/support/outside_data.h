// Data outside the repository: scans and planning problems that some tests and benchmarks can use.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace cwm::testing {

// A path below $CWM_DATA, else below ../shared/data of the source directory, in which tests run.
// Empty if it does not exist; the caller then skips itself and names the data.
inline std::optional<std::string> OutsideData(const std::string& relative) {
  const char* given = std::getenv("CWM_DATA");
  const std::filesystem::path path =
      std::filesystem::path(given != nullptr ? given : "../shared/data") / relative;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path.string();
}

}  // namespace cwm::testing
