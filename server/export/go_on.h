// Whether work that takes long is still wanted.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>

#include "absl/status/status.h"

namespace cwm::server {

// Asked between objects, rules, rows and pieces of meshes: anything but OK ends the work, which
// returns it.
using GoOn = std::function<absl::Status()>;

// Calls do_range(first, last) for [0, count) in ranges that take some milliseconds at most, and asks
// after each of them.
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
