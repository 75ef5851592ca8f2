// PCD, PCL's point cloud format, version 0.7: ascii, binary and binary_compressed.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// Reads strictly: the data must match the header. Fields may have any order and types; padding
// fields named "_" are dropped; COUNT (default 1), VIEWPOINT and POINTS are optional. An
// inconsistency is INVALID_ARGUMENT with `file`, the header's field, its value and the rule. No
// more memory is allocated than the file's bytes can fill.
absl::StatusOr<CloudFile> ParsePcd(std::string_view bytes, const std::string& file);

enum class PcdData { kBinary, kBinaryCompressed };

// Reading the result gives the same cloud. INVALID_ARGUMENT if the format cannot store it: more
// than 4 GiB, or a field name with white space.
absl::StatusOr<std::string> FormatPcd(const CloudFile& cloud, PcdData data);

}  // namespace cwm::formats
