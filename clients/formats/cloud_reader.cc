#include "clients/formats/cloud_reader.h"

#include <algorithm>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "clients/formats/file_bytes.h"
#include "clients/formats/format_error.h"
#include "clients/formats/npy.h"
#include "clients/formats/pcd.h"
#include "clients/formats/ply.h"
#include "clients/formats/xyz.h"

namespace cwm::formats {
namespace {

// The mark of UTF-8 that Windows' editors put before a text.
std::string_view WithoutByteOrderMark(std::string_view bytes) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return bytes.starts_with(kMark) ? bytes.substr(kMark.size()) : bytes;
}

// The name of a kind of file that is no cloud but often given as one, and what to do.
struct KnownKind {
  std::string_view begin;
  std::string_view rule;
};
constexpr KnownKind kKnownKinds[] = {
    {"PK\x03\x04", "is a zip archive or .npz: save one array of points with numpy.save"},
    {"# Octomap", "is an octree of OctoMap: convert it to points, e.g. by octree2pointcloud"},
    {"\x89PNG", "is an image: a depth image needs the camera's --intrinsics"},
    {"\x89HDF", "is an HDF5 file: save its points with numpy.save"},
    {"#ROSBAG", "is a bag of ROS: export its cloud as PCD, e.g. by pcl_ros bag_to_pcd"},
    {"LASF", "is a LAS or LAZ file: convert it, e.g. by pdal translate to .pcd"},
    {"\x1F\x8B", "is compressed by gzip: unpack it first"}};

bool IsWebPage(std::string_view bytes) {
  const std::size_t begin = bytes.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos) return false;
  const std::string text = absl::AsciiStrToLower(std::string(bytes.substr(begin, 14)));
  return text.starts_with("<!doctype html") || text.starts_with("<html");
}

// Says what a file is that is no cloud; empty if it is of no known kind.
std::optional<std::string> KindOf(std::string_view bytes) {
  for (const KnownKind& kind : kKnownKinds) {
    if (bytes.starts_with(kind.begin)) return std::string(kind.rule);
  }
  if (IsWebPage(bytes)) return "is a web page: the download of the file failed or needs a login";
  return std::nullopt;
}

absl::StatusOr<CloudFile> ParseAny(std::string_view bytes, const std::string& file) {
  const auto format = DetectCloudFormat(bytes);
  if (!format) {
    if (const auto kind = KindOf(bytes)) return FileError(file, {"the file", "", *kind});
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
  bytes = WithoutByteOrderMark(bytes);
  const std::string_view magic = bytes.substr(0, 3);
  if (magic == "ply") return CloudFormat::kPly;
  if (magic == "# ." || magic == "VER") return CloudFormat::kPcd;
  if (bytes.starts_with(kNpyMagic)) return CloudFormat::kNpy;
  if (LooksLikeXyz(bytes)) return CloudFormat::kXyz;
  return std::nullopt;
}

absl::StatusOr<CloudFile> ParseCloud(std::string_view bytes, const std::string& file) {
  auto cloud = ParseAny(WithoutByteOrderMark(bytes), file);
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
