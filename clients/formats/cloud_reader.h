// Any cloud file that this project reads.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

enum class CloudFormat { kPcd, kPly, kNpy, kXyz };

// By the first bytes, never by the file's name: PCD, PLY and NPY have such, XYZ is text of which the
// first line that is no comment begins with three numbers or names columns x, y and z. Nothing for
// what is none of them.
std::optional<CloudFormat> CloudFormatOf(std::string_view bytes);

// A file of any of these formats. The cloud has the fields x y z, one number each.
absl::StatusOr<CloudFile> ParseCloud(std::string_view bytes, const std::string& file);
absl::StatusOr<CloudFile> ReadCloud(const std::string& path);

}  // namespace cwm::formats
