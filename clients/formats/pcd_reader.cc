#include <cstring>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/lzf.h"
#include "clients/formats/pcd.h"
#include "clients/formats/pcd_header.h"
#include "clients/formats/text_cursor.h"

namespace cwm::formats {
namespace {

constexpr std::string_view kPadding = "_";

// `each`: the size of a point, e.g. "12 bytes"; `have`: the available data, e.g. "40 bytes of
// data".
absl::Status TooShortError(const std::string& file, const PcdHeader& header,
                           const std::string& each, const std::string& have) {
  return FileError(file, {"POINTS", absl::StrCat(header.points()),
                          absl::StrCat("must be what the data holds: at ", each,
                                       " a point there are not enough in ", have)});
}

absl::Status TooLongError(const std::string& file, const PcdHeader& header) {
  return FileError(file, {"POINTS", absl::StrCat(header.points()),
                          "must be what the data holds: there is more data after the last point"});
}

// True if the header's points take at most `limit` bytes at `bytes_per_point` (> 0).
bool Fits(const PcdHeader& header, std::size_t bytes_per_point, std::size_t limit) {
  return static_cast<std::size_t>(header.points()) <= limit / bytes_per_point;
}

CloudFile EmptyCloud(const PcdHeader& header) {
  CloudFile cloud{.width = header.width, .height = header.height, .viewpoint = header.viewpoint};
  for (const CloudField& field : header.fields) {
    if (field.name != kPadding) cloud.fields.push_back(field);
  }
  cloud.point_step = AssignOffsets(cloud.fields);
  return cloud;
}

// The place of a field's bytes in the data: point by point (binary) or field by field
// (binary_compressed).
struct Columns {
  std::size_t begin = 0;
  std::size_t stride = 0;
};

void CopyField(std::string_view data, const Columns& from, const CloudField& to, CloudFile& cloud) {
  const auto points = static_cast<std::size_t>(cloud.size());
  for (std::size_t p = 0; p < points; ++p) {
    std::memcpy(&cloud.bytes[p * cloud.point_step + to.offset],
                data.data() + from.begin + p * from.stride, to.size());
  }
}

CloudFile FromRaw(std::string_view data, const PcdHeader& header) {
  CloudFile cloud = EmptyCloud(header);
  const auto points = static_cast<std::size_t>(cloud.size());
  cloud.bytes.resize(points * cloud.point_step);
  const bool by_field = header.encoding == PcdEncoding::kBinaryCompressed;
  for (const CloudField& field : header.fields) {
    if (field.name == kPadding) continue;
    const Columns from = by_field ? Columns{points * field.offset, field.size()}
                                  : Columns{field.offset, header.point_step};
    CopyField(data, from, *cloud.Find(field.name), cloud);
  }
  return cloud;
}

absl::StatusOr<CloudFile> ReadBinary(TextCursor cursor, const PcdHeader& header,
                                     const std::string& file) {
  const std::size_t have = cursor.rest().size();
  if (!Fits(header, header.point_step, have)) {
    return TooShortError(file, header, absl::StrCat(header.point_step, " bytes"),
                         absl::StrCat(have, " bytes of data"));
  }
  const auto data = cursor.NextBytes(static_cast<std::size_t>(header.points()) * header.point_step);
  if (!cursor.OnlyPaddingLeft()) return TooLongError(file, header);
  return FromRaw(*data, header);
}

absl::StatusOr<CloudFile> ReadCompressed(TextCursor cursor, const PcdHeader& header,
                                         const std::string& file) {
  const auto sizes = cursor.NextBytes(8);
  if (!sizes) return FileError(file, {"data", "", "must begin with two sizes of four bytes"});
  std::uint32_t packed = 0;
  std::uint32_t unpacked = 0;
  std::memcpy(&packed, sizes->data(), 4);
  std::memcpy(&unpacked, sizes->data() + 4, 4);
  const auto data = cursor.NextBytes(packed);
  if (!data) {
    return FileError(file, {"compressed size", absl::StrCat(packed),
                            absl::StrCat("must be what the file holds: ", cursor.rest().size(),
                                         " bytes are left")});
  }
  if (!cursor.OnlyPaddingLeft()) return TooLongError(file, header);
  const std::size_t expected = static_cast<std::size_t>(header.points()) * header.point_step;
  if (!Fits(header, header.point_step, unpacked) || unpacked != expected) {
    return FileError(file, {"uncompressed size", absl::StrCat(unpacked),
                            absl::StrCat("must be that of POINTS, ", header.points(), " x ",
                                         header.point_step, " bytes")});
  }
  const auto raw = LzfDecompress(*data, unpacked);
  if (!raw) {
    return FileError(file, {"compressed data", absl::StrCat(packed, " bytes"),
                            absl::StrCat("must unpack to exactly ", unpacked, " bytes")});
  }
  return FromRaw(*raw, header);
}

absl::Status ReadAsciiPoint(const std::vector<std::string_view>& words, std::int64_t point,
                            const PcdHeader& header, CloudFile& cloud, const std::string& file) {
  char* bytes = &cloud.bytes[static_cast<std::size_t>(point) * cloud.point_step];
  std::size_t next_word = 0;
  for (const CloudField& field : header.fields) {
    for (std::size_t c = 0; c < field.count; ++c) {
      const std::string_view word = words[next_word++];
      if (field.name == kPadding) continue;
      if (!ParseScalar(word, field.type, bytes)) {
        return FileError(file, {absl::StrCat("point ", point, " field ", Printable(field.name)),
                                std::string(word),
                                absl::StrCat("must be of type ", std::string(NameOf(field.type)))});
      }
      bytes += SizeOf(field.type);
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<CloudFile> ReadAscii(TextCursor cursor, const PcdHeader& header,
                                    const std::string& file) {
  std::size_t words_per_point = 0;
  for (const CloudField& field : header.fields) words_per_point += field.count;
  // A word takes at least one character and a separator, which the last word does not need.
  const std::size_t have = cursor.rest().size() + 1;
  const absl::Status not_enough =
      TooShortError(file, header, absl::StrCat(words_per_point, " values"),
                    absl::StrCat(cursor.rest().size(), " bytes of text"));
  if (!Fits(header, 2 * words_per_point, have)) return not_enough;
  CloudFile cloud = EmptyCloud(header);
  cloud.bytes.resize(static_cast<std::size_t>(cloud.size()) * cloud.point_step);
  for (std::int64_t point = 0; point < cloud.size();) {
    const auto line = cursor.NextLine();
    if (!line) return not_enough;
    const auto words = SplitWords(*line);
    if (words.empty()) continue;
    if (words.size() != words_per_point) {
      return FileError(
          file, {absl::StrCat("number of values of point ", point), absl::StrCat(words.size()),
                 absl::StrCat("must be ", words_per_point)});
    }
    absl::Status read = ReadAsciiPoint(words, point++, header, cloud, file);
    if (!read.ok()) return read;
  }
  if (!cursor.OnlyPaddingLeft()) return TooLongError(file, header);
  return cloud;
}

}  // namespace

absl::StatusOr<CloudFile> ParsePcd(std::string_view bytes, const std::string& file) {
  TextCursor cursor(bytes);
  const auto header = ParsePcdHeader(cursor, file);
  if (!header.ok()) return header.status();
  switch (header->encoding) {
    case PcdEncoding::kAscii:
      return ReadAscii(cursor, *header, file);
    case PcdEncoding::kBinary:
      return ReadBinary(cursor, *header, file);
    case PcdEncoding::kBinaryCompressed:
      break;
  }
  return ReadCompressed(cursor, *header, file);
}

}  // namespace cwm::formats
