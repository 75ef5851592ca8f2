#include <cstring>
#include <limits>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/lzf.h"
#include "clients/formats/pcd.h"
#include "clients/formats/scalar.h"

namespace cwm::formats {
namespace {

char KindOf(Scalar type) {
  const std::string_view name = NameOf(type);
  return name[0] == 'f' ? 'F' : name[0] == 'u' ? 'U' : 'I';
}

std::string Header(const CloudFile& cloud, std::string_view data) {
  std::string fields = "FIELDS", sizes = "SIZE", types = "TYPE", counts = "COUNT";
  for (const CloudField& field : cloud.fields) {
    absl::StrAppend(&fields, " ", field.name);
    absl::StrAppend(&sizes, " ", SizeOf(field.type));
    absl::StrAppend(&types, " ", std::string(1, KindOf(field.type)));
    absl::StrAppend(&counts, " ", field.count);
  }
  std::string viewpoint = "VIEWPOINT";
  for (const double value : cloud.viewpoint) absl::StrAppend(&viewpoint, " ", FormatNumber(value));
  return absl::StrCat("# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n", fields, "\n",
                      sizes, "\n", types, "\n", counts, "\nWIDTH ", cloud.width, "\nHEIGHT ",
                      cloud.height, "\n", viewpoint, "\nPOINTS ", cloud.size(), "\nDATA ",
                      std::string(data), "\n");
}

// The values of all points, field after field.
std::string ByField(const CloudFile& cloud) {
  std::string columns;
  columns.reserve(cloud.bytes.size());
  for (const CloudField& field : cloud.fields) {
    for (std::size_t p = 0; p < static_cast<std::size_t>(cloud.size()); ++p) {
      columns.append(cloud.bytes, p * cloud.point_step + field.offset, field.size());
    }
  }
  return columns;
}

void AppendSize(std::size_t size, std::string& out) {
  const auto word = static_cast<std::uint32_t>(size);
  char bytes[sizeof(word)];
  std::memcpy(bytes, &word, sizeof(word));
  out.append(bytes, sizeof(word));
}

}  // namespace

absl::StatusOr<std::string> FormatPcd(const CloudFile& cloud, PcdData data) {
  for (const CloudField& field : cloud.fields) {
    if (field.name.empty() || field.name.find_first_of(" \t\r\n#") != std::string::npos) {
      return absl::InvalidArgumentError(absl::StrCat("field name \"", Printable(field.name),
                                                     "\" cannot be written to a PCD file"));
    }
  }
  if (data == PcdData::kBinary) return Header(cloud, "binary") + cloud.bytes;
  const std::string packed = LzfCompress(ByField(cloud));
  constexpr std::size_t kLimit = std::numeric_limits<std::uint32_t>::max();
  if (cloud.bytes.size() > kLimit || packed.size() > kLimit) {
    return absl::InvalidArgumentError("binary_compressed PCD holds at most 4 GiB");
  }
  std::string out = Header(cloud, "binary_compressed");
  AppendSize(packed.size(), out);
  AppendSize(cloud.bytes.size(), out);
  return out + packed;
}

}  // namespace cwm::formats
