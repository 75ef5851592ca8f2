// Progress of a transfer.
#pragma once

#include <cstdint>
#include <functional>

namespace cwm::client {

// Called after every chunk with the bytes sent or received so far and the total.
using Progress = std::function<void(std::int64_t moved_bytes, std::int64_t total_bytes)>;

}  // namespace cwm::client
