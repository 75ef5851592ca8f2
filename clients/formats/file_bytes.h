// Whole files in and out.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::formats {

// 20 million points (the server's limit) of 64 bytes, with room.
inline constexpr std::int64_t kMaxFileBytes = std::int64_t{2} << 30;

// The bytes of a regular file. PERMISSION_DENIED when it may not be read; INVALID_ARGUMENT when
// there is none (NOT_FOUND is what a server says of a world or object), and for directories,
// devices and files above the limit.
absl::StatusOr<std::string> ReadFileBytes(const std::string& path,
                                          std::int64_t max_bytes = kMaxFileBytes);

// Replaces the file at once: writes beside it and renames, so that no reader sees half a file.
absl::Status WriteFileBytes(const std::string& path, std::string_view bytes);

}  // namespace cwm::formats
