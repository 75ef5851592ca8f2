// The sentinel of indices.
#pragma once

#include <cstdint>

namespace cwm::perception {

// chosen: marks a missing index of a point, cell or vertex.
inline constexpr std::int32_t kNoIndex = -1;

}  // namespace cwm::perception
