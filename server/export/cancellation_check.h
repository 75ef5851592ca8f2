// A callback that tells long work whether to continue.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

#include "absl/status/status.h"

namespace cwm::server {

// Called between objects, rules, rows and parts of meshes. Any status but OK ends the work, which
// returns it.
using CancellationCheck = std::function<absl::Status()>;

// Calls do_range(first, last) for [0, count) in ranges that take a few milliseconds at most, and
// calls check_cancelled after each of them.
template <class DoRange>
absl::Status ForEachRange(std::size_t count, const CancellationCheck& check_cancelled,
                          const DoRange& do_range) {
  constexpr std::size_t kMaxPiece = std::size_t{1} << 13;
  for (std::size_t first = 0; first < count;) {
    const std::size_t last = std::min(count, first + kMaxPiece);
    do_range(first, last);
    if (absl::Status status = check_cancelled(); !status.ok()) return status;
    first = last;
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
