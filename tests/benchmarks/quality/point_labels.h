#pragma once

#include <cstddef>
#include <cstdint>

namespace cwm::benchmarks {

// SceneInterpretation::labels holds 10 (i + 1) + part for the object i, counted from 1. Parts from
// the ninth on share one label.
inline constexpr std::uint32_t kFirstObjectLabel = 20, kLabelsPerObject = 10;
inline constexpr std::size_t kTellableParts = 9;

}  // namespace cwm::benchmarks
