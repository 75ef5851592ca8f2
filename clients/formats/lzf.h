// The LZF byte compression that PCD files use (liblzf's stream format: literal runs, and copies of
// 3 to 264 bytes from at most 8 192 bytes back).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace cwm::formats {

// A copy of three bytes yields at most 264: no honest stream expands by more.
inline constexpr std::size_t kLzfMaxExpansion = 88;

// Never more than input + input / 32 + 1 bytes.
std::string LzfCompress(std::string_view input);

// Exactly `output_size` bytes. Nothing when the stream is cut short, points before its begin, or
// holds more or less than that. Allocates nothing when `output_size` cannot be true.
std::optional<std::string> LzfDecompress(std::string_view input, std::size_t output_size);

}  // namespace cwm::formats
