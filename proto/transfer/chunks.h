// How large the pieces are in which bytes travel. GetServerInfo publishes both.
#pragma once

#include <cstdint>

namespace cwm {

// The most bytes of one chunk of an upload, and what a server sends at once.
inline constexpr std::int64_t kMaxChunkBytes = 1 << 20;
// The most bytes of one message.
inline constexpr std::int64_t kMaxMessageBytes = 16 << 20;

}  // namespace cwm
