#include <cmath>
#include <cstring>

#include "absl/strings/str_cat.h"
#include "clients/formats/format_error.h"
#include "clients/simulator/mesh_formats.h"
#include "clients/simulator/text_lines.h"

namespace cwm::simulator {
namespace {

using formats::MeshFile;

// 80 bytes of anything, the number of triangles, then each as a normal, three vertices and two bytes
// of attributes, all little-endian as this machine is.
constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kTriangleBytes = 50;

std::size_t AnnouncedTriangles(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes - sizeof count, sizeof count);
  return count;
}

bool IsBinary(std::string_view bytes) {
  return bytes.size() >= kHeaderBytes &&
         bytes.size() == kHeaderBytes + kTriangleBytes * AnnouncedTriangles(bytes);
}

void AddTriangle(MeshFile& mesh) {
  const auto end = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.triangles.push_back({end - 3, end - 2, end - 1});
}

absl::StatusOr<MeshFile> ParseBinary(std::string_view bytes, const std::string& file) {
  MeshFile mesh;
  for (std::size_t i = 0; i < AnnouncedTriangles(bytes); ++i) {
    const char* triangle = bytes.data() + kHeaderBytes + i * kTriangleBytes;
    float numbers[12];  // the normal first
    std::memcpy(numbers, triangle, sizeof numbers);
    for (std::size_t vertex = 1; vertex <= 3; ++vertex) {
      const float* p = numbers + 3 * vertex;
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
        return formats::FileError(file, {.field = absl::StrCat("triangles[", i, "]"),
                                         .value = "",
                                         .rule = "must have finite vertices"});
      }
      mesh.vertices.push_back({p[0], p[1], p[2]});
    }
    AddTriangle(mesh);
  }
  return mesh;
}

absl::StatusOr<MeshFile> ParseText(std::string_view bytes, const std::string& file) {
  TextLines lines(bytes, file);
  MeshFile mesh;
  std::size_t corners = 0;  // of the facet that is open
  bool ended = false;
  for (auto words = lines.Next(); words; words = lines.Next()) {
    const std::string_view key = words->front();
    if (key == "vertex") {
      const auto point = lines.ReadPoint(*words);
      if (!point.ok()) return point.status();
      mesh.vertices.push_back(*point);
      ++corners;
    } else if (key == "endfacet") {
      if (corners != 3) {
        return lines.Error("facet", absl::StrCat(corners, " vertices"), "must have three");
      }
      AddTriangle(mesh);
      corners = 0;
    } else if (key == "endsolid") {
      ended = true;
    } else if (key != "solid" && key != "facet" && key != "outer" && key != "endloop") {
      return lines.Error("the word", key, "belongs to no STL file");
    }
  }
  if (!ended)
    return lines.Error("the file", "",
                       "must end with endsolid, or be as long as a binary STL says it is");
  return mesh;
}

}  // namespace

absl::StatusOr<MeshFile> ParseStl(std::string_view bytes, const std::string& file) {
  return IsBinary(bytes) ? ParseBinary(bytes, file) : ParseText(bytes, file);
}

}  // namespace cwm::simulator
