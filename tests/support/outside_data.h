// Data that the repository does not hold: scans and planning problems that some tests and
// benchmarks can use.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace cwm::testing {

// A path below $CWM_DATA, else below ../shared/data of the source directory (tests run from there);
// nothing where it is absent: the caller skips itself by name.
inline std::optional<std::string> OutsideData(const std::string& relative) {
  const char* given = std::getenv("CWM_DATA");
  const std::filesystem::path path =
      std::filesystem::path(given != nullptr ? given : "../shared/data") / relative;
  if (!std::filesystem::exists(path)) return std::nullopt;
  return path.string();
}

}  // namespace cwm::testing
