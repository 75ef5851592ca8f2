// Writes PNG images of one channel of 16 bits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::simulator {

// `values` are row-major, width x height of them. RESOURCE_EXHAUSTED without memory.
absl::StatusOr<std::string> FormatPng16(int width, int height,
                                        const std::vector<std::uint16_t>& values);

}  // namespace cwm::simulator
