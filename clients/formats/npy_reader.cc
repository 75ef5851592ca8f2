#include <algorithm>
#include <cstring>
#include <limits>
#include <map>
#include <optional>

#include "absl/strings/ascii.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "clients/formats/format_error.h"
#include "clients/formats/npy.h"
#include "clients/formats/npy_header.h"

namespace cwm::formats {
namespace {

// chosen: the same limit as for a PCD; no valid file is wider.
constexpr std::size_t kMaxPointBytes = 1 << 16;
constexpr std::int64_t kMaxAside = std::numeric_limits<std::int32_t>::max();

// The number of padding bytes in a type such as "|V4"; empty for other types.
std::optional<std::size_t> PaddingBytes(std::string_view type) {
  if (!type.starts_with("|V")) return std::nullopt;
  type.remove_prefix(2);
  std::uint64_t bytes = 0;
  if (!absl::SimpleAtoi({type.data(), type.size()}, &bytes) || bytes > kMaxPointBytes) {
    return std::nullopt;
  }
  return static_cast<std::size_t>(bytes);
}

std::string ShapeText(const std::vector<std::int64_t>& shape) {
  return absl::StrCat("(", absl::StrJoin(shape, ", "), ")");
}

// A field of the cloud with its place in the file: in each point, or in an array of its own.
struct Column {
  CloudField field;
  std::size_t file_offset = 0;
  bool big_endian = false;
};

class NpyReader {
 public:
  NpyReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  absl::StatusOr<CloudFile> Read() {
    const auto header = ParseNpyHeader(bytes_, file_);
    if (!header.ok()) return header.status();
    absl::Status status = header->members.empty() ? PlainColumns(*header) : Members(*header);
    if (status.ok()) status = Points(*header);
    if (status.ok() && header->fortran_order) OrderByColumns(*header);
    if (!status.ok()) return status;
    return Cloud(bytes_.substr(header->data_begin));
  }

 private:
  absl::Status Error(const std::string& field, const std::string& value,
                     const std::string& rule) const {
    return FileError(file_, {field, value, rule});
  }

  absl::Status TypeError(const std::string& field, const std::string& type,
                         const std::string& rule) const {
    if (type.find('O') == std::string::npos) return Error(field, type, rule);
    return Error(field, type, absl::StrCat(rule, ": objects are pickled and never read"));
  }

  // The columns x y z of a plain array; further ones are skipped.
  absl::Status PlainColumns(const NpyHeader& header) {
    const auto type = NumberType(header.type);
    if (!type || (type->type != Scalar::kF32 && type->type != Scalar::kF64)) {
      return TypeError("descr", header.type,
                       "must be <f4, <f8, >f4 or >f8, or a structure with x, y and z");
    }
    const std::vector<std::int64_t>& shape = header.shape;
    if ((shape.size() != 2 && shape.size() != 3) || shape.back() < 3 ||
        shape.back() > kMaxNpyColumns) {
      return Error("shape", ShapeText(shape),
                   absl::StrCat("must be (N, 3), or (H, W, 3) for an image of points; with up to ",
                                kMaxNpyColumns, " columns, of which the first three are x y z"));
    }
    for (const char* axis : {"x", "y", "z"}) {
      columns_.push_back({{.name = axis, .type = type->type}, file_step_, type->big_endian});
      file_step_ += SizeOf(type->type);
    }
    file_step_ = static_cast<std::size_t>(shape.back()) * SizeOf(type->type);
    point_dimensions_ = shape.size() - 1;
    return absl::OkStatus();
  }

  // The columns of a structured type's members.
  absl::Status Members(const NpyHeader& header) {
    if (header.shape.empty() || header.shape.size() > 2) {
      return Error("shape", ShapeText(header.shape),
                   "must be (N,), or (H, W) for an image of points, where descr is a structure");
    }
    point_dimensions_ = header.shape.size();
    for (const NpyMember& member : header.members) {
      if (absl::Status status = AddMember(member); !status.ok()) return status;
    }
    for (const char* axis : {"x", "y", "z"}) {
      if (!HasField(axis)) return Error(absl::StrCat("member ", axis), "", "is missing from descr");
    }
    return absl::OkStatus();
  }

  absl::Status AddMember(const NpyMember& member) {
    static const std::map<std::string, std::string> kPcdNames = {
        {"nx", "normal_x"}, {"ny", "normal_y"}, {"nz", "normal_z"}};
    const std::string place = absl::StrCat("type of member \"", Printable(member.name), "\"");
    if (const auto padding = PaddingBytes(member.type); padding && member.name.empty()) {
      return Advance(*padding, place);
    }
    const auto type = NumberType(member.type);
    if (!type) {
      return TypeError(place, member.type, "must be an integer or float of 1 to 8 bytes, as <f4");
    }
    std::size_t count = 1;
    for (const std::int64_t n : member.shape) {
      if (n < 1 || static_cast<std::uint64_t>(n) > kMaxPointBytes / count) {
        return Error(absl::StrCat("shape of member ", Printable(member.name)),
                     ShapeText(member.shape), "must be of 1 to 65536 numbers");
      }
      count *= static_cast<std::size_t>(n);
    }
    const auto renamed = kPcdNames.find(member.name);
    Column column{{.name = renamed == kPcdNames.end() ? member.name : renamed->second,
                   .type = type->type,
                   .count = count},
                  file_step_,
                  type->big_endian};
    if (!IsName(column.field.name)) {
      return Error("name of a member", absl::StrCat("\"", column.field.name, "\""),
                   "must have letters, digits, _, - and . alone");
    }
    if (HasField(column.field.name)) {
      return Error("member", column.field.name, "must not appear twice");
    }
    const std::size_t size = column.field.size();
    columns_.push_back(std::move(column));
    return Advance(size, place);
  }

  static bool IsName(std::string_view name) {
    return !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
      return absl::ascii_isalnum(c) || c == '_' || c == '-' || c == '.';
    });
  }

  absl::Status Advance(std::size_t bytes, const std::string& place) {
    file_step_ += bytes;
    if (file_step_ <= kMaxPointBytes) return absl::OkStatus();
    return Error(place, absl::StrCat(file_step_, " bytes into a point"), "must end within 65536");
  }

  bool HasField(std::string_view name) const {
    return std::any_of(columns_.begin(), columns_.end(),
                       [&](const Column& column) { return column.field.name == name; });
  }

  // Sets the number of points, and checks that the data has exactly their size.
  absl::Status Points(const NpyHeader& header) {
    for (std::size_t i = 0; i < point_dimensions_; ++i) {
      if (header.shape[i] > kMaxAside) {
        return Error("shape", ShapeText(header.shape),
                     absl::StrCat("must be at most ", kMaxAside, " points a side"));
      }
    }
    width_ = header.shape[point_dimensions_ - 1];
    height_ = point_dimensions_ == 2 ? header.shape[0] : 1;
    const auto points = static_cast<std::uint64_t>(width_) * static_cast<std::uint64_t>(height_);
    const std::uint64_t have = bytes_.size() - header.data_begin;
    if (have % file_step_ == 0 && have / file_step_ == points) return absl::OkStatus();
    return Error("shape", ShapeText(header.shape),
                 absl::StrCat("must be what the data holds: ", points, " points of ", file_step_,
                              " bytes are not the ", have, " bytes that there are"));
  }

  // Fortran order: the first index runs fastest. Plain arrays have one column after the other.
  void OrderByColumns(const NpyHeader& header) {
    by_columns_ = true;
    if (!header.members.empty()) return;
    const auto points = static_cast<std::size_t>(width_ * height_);
    file_step_ = SizeOf(columns_.front().field.type);
    for (Column& column : columns_) column.file_offset *= points;
  }

  // The place in the file's order of point p, which counts row by row.
  std::size_t PlaceOf(std::size_t p) const {
    if (!by_columns_) return p;
    const auto width = static_cast<std::size_t>(width_), height = static_cast<std::size_t>(height_);
    return p % width * height + p / width;
  }

  CloudFile Cloud(std::string_view data) const {
    CloudFile cloud{.width = width_, .height = height_};
    for (const Column& column : columns_) cloud.fields.push_back(column.field);
    cloud.point_step = AssignOffsets(cloud.fields);
    const auto points = static_cast<std::size_t>(cloud.size());
    cloud.bytes.resize(points * cloud.point_step);
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      const CloudField& to = cloud.fields[c];
      for (std::size_t p = 0; p < points; ++p) {
        char* out = &cloud.bytes[p * cloud.point_step + to.offset];
        std::memcpy(out, data.data() + PlaceOf(p) * file_step_ + columns_[c].file_offset,
                    to.size());
        if (!columns_[c].big_endian) continue;
        const std::size_t each = SizeOf(to.type);
        for (char* number = out; number < out + to.size(); number += each) {
          std::reverse(number, number + each);
        }
      }
    }
    return cloud;
  }

  std::string_view bytes_;
  const std::string& file_;
  std::vector<Column> columns_;
  std::size_t file_step_ = 0;  // bytes from point to point in the file
  bool by_columns_ = false;
  std::size_t point_dimensions_ = 0;
  std::int64_t width_ = 0, height_ = 1;
};

}  // namespace

absl::StatusOr<CloudFile> ParseNpy(std::string_view bytes, const std::string& file) {
  return NpyReader(bytes, file).Read();
}

}  // namespace cwm::formats
