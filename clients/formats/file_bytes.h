// Reads and writes whole files.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace cwm::formats {

// derived: 20 million points (the server's limit) of 64 bytes, with room to spare.
inline constexpr std::int64_t kMaxFileBytes = std::int64_t{2} << 30;

// The bytes of a regular file. PERMISSION_DENIED if it may not be read; INVALID_ARGUMENT if it does
// not exist (NOT_FOUND is reserved for worlds and objects of a server), and for directories,
// devices and files above the limit.
absl::StatusOr<std::string> ReadFileBytes(const std::string& path,
                                          std::int64_t max_bytes = kMaxFileBytes);

// Replaces the file atomically: writes beside it and renames, so that no reader sees half a file.
absl::Status WriteFileBytes(const std::string& path, std::string_view bytes);

}  // namespace cwm::formats
