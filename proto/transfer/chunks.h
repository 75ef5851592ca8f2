// Sizes of the pieces in which bytes travel. GetServerInfo publishes both.
#pragma once

#include <cstdint>

namespace cwm {

// The largest chunk of an upload, and of a reply that the server sends in chunks, in bytes.
inline constexpr std::int64_t kMaxChunkBytes = 1 << 20;
// The largest message, in bytes.
inline constexpr std::int64_t kMaxMessageBytes = 16 << 20;

}  // namespace cwm
