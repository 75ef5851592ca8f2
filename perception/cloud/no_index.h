// The one sentinel of indices.
#pragma once

#include <cstdint>

namespace cwm::perception {

// chosen: stands where an index of a point, cell or vertex is asked for and there is none.
inline constexpr std::int32_t kNoIndex = -1;

}  // namespace cwm::perception
