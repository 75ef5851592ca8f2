// Reads any supported cloud file.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

enum class CloudFormat { kPcd, kPly, kNpy, kXyz };

// Recognises the format by the first bytes, never by the file's name. PCD, PLY and NPY have a
// magic; XYZ is text whose first line that is not a comment begins with three numbers or names
// columns x, y and z. Empty for other files.
std::optional<CloudFormat> DetectCloudFormat(std::string_view bytes);

// Reads a file of any of these formats. The cloud has the fields x y z, one number each.
absl::StatusOr<CloudFile> ParseCloud(std::string_view bytes, const std::string& file);
absl::StatusOr<CloudFile> ReadCloud(const std::string& path);

}  // namespace cwm::formats
