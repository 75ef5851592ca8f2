// How far a transfer is.
#pragma once

#include <cstdint>
#include <functional>

namespace cwm::client {

// Told after every chunk: bytes sent or received so far, of how many.
using Progress = std::function<void(std::int64_t moved_bytes, std::int64_t total_bytes)>;

}  // namespace cwm::client
