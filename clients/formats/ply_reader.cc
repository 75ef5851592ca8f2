#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/formats/ply.h"
#include "clients/formats/ply_header.h"

namespace cwm::formats {
namespace {

// Reads the data's numbers one after the other in any encoding.
class NumberSource {
 public:
  NumberSource(TextCursor cursor, PlyEncoding encoding) : cursor_(cursor), encoding_(encoding) {}

  // The next number as little-endian bytes; false if it is missing or not of the type.
  [[nodiscard]] bool Next(Scalar type, char* bytes) {
    if (encoding_ == PlyEncoding::kAscii) {
      const auto word = cursor_.NextWord();
      return word && ParseScalar(*word, type, bytes);
    }
    const auto raw = cursor_.NextBytes(SizeOf(type));
    if (!raw) return false;
    std::memcpy(bytes, raw->data(), raw->size());
    if (encoding_ == PlyEncoding::kBigEndian) std::reverse(bytes, bytes + raw->size());
    return true;
  }

  std::size_t bytes_left() const { return cursor_.rest().size(); }
  bool AtEnd() const { return cursor_.OnlyPaddingLeft(); }

 private:
  TextCursor cursor_;
  PlyEncoding encoding_;
};

// A file being read: the vertices, and the faces if they are wanted.
class PlyParser {
 public:
  explicit PlyParser(const std::string& file) : file_(file) {}

  absl::Status Parse(std::string_view bytes) {
    TextCursor cursor(bytes);
    const auto header = ParsePlyHeader(cursor, file_);
    if (!header.ok()) return header.status();
    NumberSource source(cursor, header->encoding);
    for (const PlyElement& element : header->elements) {
      if (absl::Status status = ReadElement(element, header->encoding, source); !status.ok()) {
        return status;
      }
    }
    if (!has_vertices_) return Error("element vertex", "", "is missing");
    if (!source.AtEnd()) {
      return Error("data", absl::StrCat(source.bytes_left(), " bytes too long"),
                   "must end with the last element");
    }
    return absl::OkStatus();
  }

  CloudFile TakeCloud() { return std::move(cloud_); }

  absl::StatusOr<MeshFile> Mesh() const {
    MeshFile mesh;
    const CloudField* axes[3] = {cloud_.Find("x"), cloud_.Find("y"), cloud_.Find("z")};
    mesh.vertices.resize(static_cast<std::size_t>(cloud_.size()));
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      for (int axis = 0; axis < 3; ++axis) {
        const char* bytes = &cloud_.bytes[v * cloud_.point_step + axes[axis]->offset];
        mesh.vertices[v][axis] = ToDouble(bytes, axes[axis]->type);
        if (!std::isfinite(mesh.vertices[v][axis])) {
          return Error(absl::StrCat("vertex ", v, " ", axes[axis]->name), "not finite",
                       "must be a finite number");
        }
      }
    }
    if (polygon_sizes_.empty())
      return Error("element face", "", "must hold at least one face, a triangle or a polygon");
    const absl::Status split = SplitPolygons(mesh);
    if (!split.ok()) return split;
    return mesh;
  }

 private:
  absl::Status Error(const std::string& field, const std::string& value,
                     const std::string& rule) const {
    return FileError(file_, {.field = field, .value = value, .rule = rule});
  }

  absl::Status ReadElement(const PlyElement& element, PlyEncoding encoding, NumberSource& source) {
    const std::size_t max_rows = (source.bytes_left() + 1) / element.MinRowBytes(encoding);
    if (static_cast<std::uint64_t>(element.count) > max_rows) {
      return Error(
          absl::StrCat("count of element ", Printable(element.name)), absl::StrCat(element.count),
          absl::StrCat("must be what the data holds: ", source.bytes_left(), " bytes are left"));
    }
    if (element.name == "vertex") return ReadVertices(element, source);
    for (std::int64_t row = 0; row < element.count; ++row) {
      for (const PlyProperty& property : element.properties) {
        absl::Status status = ReadValue(element, row, property, source);
        if (!status.ok()) return status;
      }
    }
    return absl::OkStatus();
  }

  absl::Status ReadVertices(const PlyElement& element, NumberSource& source) {
    static const std::map<std::string, std::string> kPcdNames = {
        {"nx", "normal_x"}, {"ny", "normal_y"}, {"nz", "normal_z"}};
    has_vertices_ = true;
    for (const PlyProperty& property : element.properties) {
      if (property.list_count) {
        return Error("property", property.name, "must not be a list in element vertex");
      }
      const auto renamed = kPcdNames.find(property.name);
      cloud_.fields.push_back({.name = renamed == kPcdNames.end() ? property.name : renamed->second,
                               .type = property.type});
    }
    for (const char* axis : {"x", "y", "z"}) {
      if (cloud_.Find(axis) == nullptr) {
        return Error(absl::StrCat("property ", axis), "", "is missing from element vertex");
      }
    }
    cloud_.point_step = AssignOffsets(cloud_.fields);
    cloud_.width = element.count;
    cloud_.bytes.resize(static_cast<std::size_t>(element.count) * cloud_.point_step);
    char* bytes = cloud_.bytes.data();
    for (std::int64_t row = 0; row < element.count; ++row) {
      for (const CloudField& field : cloud_.fields) {
        if (!source.Next(field.type, bytes))
          return BadNumber("vertex", row, field.name, field.type);
        bytes += field.size();
      }
    }
    return absl::OkStatus();
  }

  absl::Status BadNumber(const std::string& element, std::int64_t row, const std::string& property,
                         Scalar type) const {
    return Error(absl::StrCat(Printable(element), " ", row, " property ", Printable(property)), "",
                 absl::StrCat("must be there and of type ", std::string(NameOf(type))));
  }

  // Reads a value outside of vertices: skips it unless it is the list of a face's corners.
  absl::Status ReadValue(const PlyElement& element, std::int64_t row, const PlyProperty& property,
                         NumberSource& source) {
    std::int64_t length = 1;
    char bytes[8];
    if (property.list_count) {
      if (!source.Next(*property.list_count, bytes)) {
        return BadNumber(element.name, row, property.name, *property.list_count);
      }
      length = static_cast<std::int64_t>(ToDouble(bytes, *property.list_count));
    }
    const bool corners = property.list_count && element.name == "face" &&
                         (property.name == "vertex_indices" || property.name == "vertex_index");
    if (length < (corners ? 3 : 0) || length > static_cast<std::int64_t>(source.bytes_left())) {
      return Error(
          absl::StrCat(Printable(element.name), " ", row, " length of ", Printable(property.name)),
          absl::StrCat(length),
          absl::StrCat("must be at least ", corners ? 3 : 0, " and no more than the data holds"));
    }
    for (std::int64_t i = 0; i < length; ++i) {
      if (!source.Next(property.type, bytes)) {
        return BadNumber(element.name, row, property.name, property.type);
      }
      if (corners) corners_.push_back(ToDouble(bytes, property.type));
    }
    if (corners) polygon_sizes_.push_back(length);
    return absl::OkStatus();
  }

  absl::Status SplitPolygons(MeshFile& mesh) const {
    const auto vertices = static_cast<double>(mesh.vertices.size());
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      const double index = corners_[i];
      if (index >= 0 && index < vertices && index == std::floor(index)) continue;
      return Error(absl::StrCat("face corner ", i), FormatNumber(index),
                   absl::StrCat("must be the index of one of ", mesh.vertices.size(), " vertices"));
    }
    std::size_t begin = 0;
    for (const std::int64_t size : polygon_sizes_) {
      const auto corner = [&](std::int64_t i) {
        return static_cast<std::uint32_t>(corners_[begin + static_cast<std::size_t>(i)]);
      };
      for (std::int64_t i = 2; i < size; ++i) {
        mesh.triangles.push_back({corner(0), corner(i - 1), corner(i)});
      }
      begin += static_cast<std::size_t>(size);
    }
    return absl::OkStatus();
  }

  const std::string& file_;
  CloudFile cloud_;
  bool has_vertices_ = false;
  std::vector<double> corners_;  // of all faces, one after the other
  std::vector<std::int64_t> polygon_sizes_;
};

}  // namespace

absl::StatusOr<CloudFile> ParsePlyCloud(std::string_view bytes, const std::string& file) {
  PlyParser parser(file);
  if (absl::Status status = parser.Parse(bytes); !status.ok()) return status;
  return parser.TakeCloud();
}

absl::StatusOr<MeshFile> ParsePlyMesh(std::string_view bytes, const std::string& file) {
  PlyParser parser(file);
  if (absl::Status status = parser.Parse(bytes); !status.ok()) return status;
  return parser.Mesh();
}

bool HasPlyFaces(std::string_view bytes) {
  TextCursor cursor(bytes);
  const auto header = ParsePlyHeader(cursor, "");
  return header.ok() &&
         std::any_of(header->elements.begin(), header->elements.end(),
                     [](const PlyElement& e) { return e.name == "face" && e.count > 0; });
}

}  // namespace cwm::formats
