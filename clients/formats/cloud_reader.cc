#include "clients/formats/cloud_reader.h"

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/pcd.h"
#include "clients/formats/ply.h"

namespace cwm::formats {
namespace {

absl::StatusOr<CloudFile> Parse(std::string_view bytes, const std::string& path) {
  const std::string_view magic = bytes.substr(0, 3);
  if (magic == "ply") return ParsePlyCloud(bytes, path);
  if (magic == "# ." || magic == "VER") return ParsePcd(bytes, path);
  return FileError(path, {"first line", std::string(bytes.substr(0, 12)),
                          "must be that of a PCD (\"# .PCD\") or PLY (\"ply\") file"});
}

}  // namespace

absl::StatusOr<CloudFile> ReadCloud(const std::string& path) {
  const auto bytes = ReadFileBytes(path);
  if (!bytes.ok()) return bytes.status();
  auto cloud = Parse(*bytes, path);
  if (!cloud.ok()) return cloud;
  for (const char* axis : {"x", "y", "z"}) {
    const CloudField* field = cloud->Find(axis);
    if (field == nullptr) {
      return FileError(path, {absl::StrCat("field ", axis), "", "is missing from the cloud"});
    }
    if (field->count != 1) {
      return FileError(
          path, {absl::StrCat("COUNT of field ", axis), absl::StrCat(field->count), "must be 1"});
    }
  }
  return cloud;
}

}  // namespace cwm::formats
