// Any cloud file that this project reads.
#pragma once

#include <string>

#include "absl/status/statusor.h"
#include "clients/formats/cloud_file.h"

namespace cwm::formats {

// Reads PCD or PLY, told apart by their first bytes and never by the file's name. The cloud has the
// fields x y z, one number each.
absl::StatusOr<CloudFile> ReadCloud(const std::string& path);

}  // namespace cwm::formats
