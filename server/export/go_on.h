// A callback that tells long work whether to continue.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

#include "absl/status/status.h"

namespace cwm::server {

// Called between objects, rules, rows and parts of meshes. Any status but OK ends the work, which
// returns it.
using GoOn = std::function<absl::Status()>;

// Calls do_range(first, last) for [0, count) in ranges that take a few milliseconds at most, and
// calls go_on after each of them.
template <class DoRange>
absl::Status InPieces(std::size_t count, const GoOn& go_on, const DoRange& do_range) {
  constexpr std::size_t kMaxPiece = std::size_t{1} << 13;
  for (std::size_t first = 0; first < count;) {
    const std::size_t last = std::min(count, first + kMaxPiece);
    do_range(first, last);
    if (absl::Status status = go_on(); !status.ok()) return status;
    first = last;
  }
  return absl::OkStatus();
}

}  // namespace cwm::server
