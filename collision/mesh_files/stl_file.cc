#include "collision/mesh_files/stl_file.h"

#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/line_reader.h"
#include "collision/mesh_files/mesh_builder.h"

namespace cwm::collision {
namespace {

constexpr std::size_t kHeader = 84;    // 80 bytes of arbitrary content and the number of triangles
constexpr std::size_t kTriangle = 50;  // a normal and three corners as floats, two arbitrary bytes
constexpr std::size_t kCorners = 12;   // offset of the corners in a triangle

absl::Status InvalidStl(const std::string& rule) { return absl::InvalidArgumentError(rule); }

std::uint32_t CountIn(std::string_view bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader) std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return count;
}

absl::StatusOr<TriangleMesh> ReadBinary(std::string_view bytes, const MeshFileLimits& limits) {
  MeshBuilder mesh(limits.max_triangles);
  for (std::size_t at = kHeader; at < bytes.size(); at += kTriangle) {
    float c[9];
    std::memcpy(c, bytes.data() + at + kCorners, sizeof(c));
    const absl::Status status =
        mesh.Add({Vector3(c[0], c[1], c[2]), Vector3(c[3], c[4], c[5]), Vector3(c[6], c[7], c[8])});
    if (!status.ok()) return status;
  }
  return std::move(mesh).Finish();
}

class TextReader {
 public:
  explicit TextReader(const MeshFileLimits& limits) : mesh_(limits.max_triangles) {}

  absl::StatusOr<TriangleMesh> Read(std::string_view text) {
    LineReader lines(text);
    while (lines.Next()) {
      if (absl::Status status = ReadLine(lines); !status.ok()) return status;
    }
    if (is_open_) return InvalidStl("must close its last facet");
    return std::move(mesh_).Finish();
  }

 private:
  absl::Status ReadLine(const LineReader& line) {
    if (line.Is("vertex")) return AddCorner(line);
    if (line.Is("facet") && !is_open_) {
      is_open_ = true;
      corners_.clear();
      return absl::OkStatus();
    }
    if (line.Is("endfacet") && is_open_ && corners_.size() == 3) {
      is_open_ = false;
      return mesh_.Add({corners_[0], corners_[1], corners_[2]});
    }
    for (const char* known : {"solid", "outer", "endloop", "endsolid"}) {
      if (line.Is(known)) return absl::OkStatus();
    }
    return line.Fault("must be part of a facet with three vertices");
  }

  absl::Status AddCorner(const LineReader& line) {
    const std::optional<Vector3> corner = line.VectorAt(1);
    if (!corner.has_value() || line.words() != 4) return line.Fault("must have three numbers");
    if (!is_open_ || corners_.size() == 3) return line.Fault("must be one of three of a facet");
    corners_.push_back(*corner);
    return absl::OkStatus();
  }

  MeshBuilder mesh_;
  std::vector<Vector3> corners_;  // of the open facet
  bool is_open_ = false;
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadStl(std::string_view bytes, const MeshFileLimits& limits) {
  const std::uint32_t count = CountIn(bytes);
  if (bytes.size() >= kHeader && bytes.size() == kHeader + kTriangle * std::size_t{count}) {
    return ReadBinary(bytes, limits);
  }
  if (bytes.starts_with("solid")) return TextReader(limits).Read(bytes);
  return InvalidStl(absl::StrCat(
      "must begin with \"solid\" (STL as text) or be ", kHeader + kTriangle * std::size_t{count},
      " bytes long, ", kHeader, " and ", kTriangle, " for each of the ", count,
      " triangles that it says it has, is ", bytes.size(), " bytes long"));
}

}  // namespace cwm::collision
