#include "clients/formats/cloud_reader.h"

#include <algorithm>

#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/npy.h"
#include "clients/formats/pcd.h"
#include "clients/formats/ply.h"
#include "clients/formats/xyz.h"

namespace cwm::formats {
namespace {

absl::StatusOr<CloudFile> ParseAny(std::string_view bytes, const std::string& file) {
  const auto format = DetectCloudFormat(bytes);
  if (!format) {
    const std::string_view first = bytes.substr(0, std::min<std::size_t>(bytes.find('\n'), 12));
    return FileError(file,
                     {"first line", std::string(first),
                      "must be that of a PCD (\"# .PCD\"), PLY (\"ply\") or NPY (\"\\x93NUMPY\") "
                      "file, or begin with three numbers (XYZ)"});
  }
  switch (*format) {
    case CloudFormat::kPcd:
      return ParsePcd(bytes, file);
    case CloudFormat::kPly:
      return ParsePlyCloud(bytes, file);
    case CloudFormat::kNpy:
      return ParseNpy(bytes, file);
    case CloudFormat::kXyz:
      break;
  }
  return ParseXyz(bytes, file);
}

}  // namespace

std::optional<CloudFormat> DetectCloudFormat(std::string_view bytes) {
  const std::string_view magic = bytes.substr(0, 3);
  if (magic == "ply") return CloudFormat::kPly;
  if (magic == "# ." || magic == "VER") return CloudFormat::kPcd;
  if (bytes.starts_with(kNpyMagic)) return CloudFormat::kNpy;
  if (LooksLikeXyz(bytes)) return CloudFormat::kXyz;
  return std::nullopt;
}

absl::StatusOr<CloudFile> ParseCloud(std::string_view bytes, const std::string& file) {
  auto cloud = ParseAny(bytes, file);
  if (!cloud.ok()) return cloud;
  for (const char* axis : {"x", "y", "z"}) {
    const CloudField* field = cloud->Find(axis);
    if (field == nullptr) {
      return FileError(file, {absl::StrCat("field ", axis), "", "is missing from the cloud"});
    }
    if (field->count != 1) {
      return FileError(
          file, {absl::StrCat("COUNT of field ", axis), absl::StrCat(field->count), "must be 1"});
    }
  }
  return cloud;
}

absl::StatusOr<CloudFile> ReadCloud(const std::string& path) {
  const auto bytes = ReadFileBytes(path);
  if (!bytes.ok()) return bytes.status();
  return ParseCloud(*bytes, path);
}

}  // namespace cwm::formats
