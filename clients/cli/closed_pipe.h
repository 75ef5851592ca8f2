// Detects that nobody reads the process's output any more.
#pragma once

#include <chrono>
#include <iosfwd>

namespace cwm::cli {

// True if `out` is the process's stdout and the other end of that pipe (or terminal) is closed, as
// after `cwm watch | head -1`; waits up to `wait` for that. False for files and other streams.
bool IsPipeClosed(const std::ostream& out,
                  std::chrono::milliseconds wait = std::chrono::milliseconds(0));

}  // namespace cwm::cli
