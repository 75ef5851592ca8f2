// The LZF compression of PCD files (liblzf's stream format: literal runs, and copies of 3 to 264
// bytes from at most 8 192 bytes back).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace cwm::formats {

// derived: a copy of three bytes yields at most 264, so no valid stream expands by more.
inline constexpr std::size_t kLzfMaxExpansion = 88;

// At most input + input / 32 + 1 bytes.
std::string LzfCompress(std::string_view input);

// Exactly `output_size` bytes; empty if the stream is truncated, refers to bytes before its begin,
// or has another size. Allocates nothing if `output_size` is impossible.
std::optional<std::string> LzfDecompress(std::string_view input, std::size_t output_size);

}  // namespace cwm::formats
