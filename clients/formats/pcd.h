// PCD, the point cloud format of PCL, version 0.7: ascii, binary and binary_compressed.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// Reads strictly: whatever the header promises must be what the data holds. Any order and types of
// fields; padding fields named "_" are dropped; COUNT may be left out (1 each), VIEWPOINT and
// POINTS too. A lie is INVALID_ARGUMENT naming `file`, the header's field, its value and the rule;
// memory beyond the file's own size is taken only as far as its bytes can fill it.
absl::StatusOr<CloudFile> ParsePcd(std::string_view bytes, const std::string& file);

enum class PcdData { kBinary, kBinaryCompressed };

// Reading it back gives the same cloud. INVALID_ARGUMENT when the format cannot hold it: over 4
// GiB, or a field name with white space.
absl::StatusOr<std::string> FormatPcd(const CloudFile& cloud, PcdData data);

}  // namespace cwm::formats
