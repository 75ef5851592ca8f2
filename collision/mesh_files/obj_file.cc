#include "collision/mesh_files/obj_file.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "collision/mesh_files/line_reader.h"
#include "collision/mesh_files/mesh_builder.h"
#include "collision/xml/xml_element.h"

namespace cwm::collision {
namespace {

class ObjReader {
 public:
  explicit ObjReader(const MeshFileLimits& limits) : mesh_(limits.max_triangles) {}

  absl::StatusOr<TriangleMesh> Read(std::string_view text) {
    LineReader lines(text);
    while (lines.Next()) {
      absl::Status status;
      if (lines.word(0) == "v") status = AddVertex(lines);
      if (lines.word(0) == "f") status = AddFace(lines);
      if (!status.ok()) return status;
    }
    return std::move(mesh_).Finish();
  }

 private:
  absl::Status AddVertex(const LineReader& line) {
    const std::optional<Vector3> vertex = line.VectorAt(1);
    if (!vertex.has_value()) return line.Fault("a vertex must have three numbers");
    vertices_.push_back(*vertex);
    return absl::OkStatus();
  }

  absl::Status AddFace(const LineReader& line) {
    std::vector<Vector3> corners;
    for (std::size_t i = 1; i < line.words() && !line.word(i).starts_with('#'); ++i) {
      const std::optional<std::size_t> vertex = VertexOf(line.word(i));
      if (!vertex.has_value()) {
        return line.Fault(absl::StrCat("corner ", Quoted(line.word(i)), " must be one of the ",
                                       vertices_.size(), " vertices that come before the face"));
      }
      corners.push_back(vertices_[*vertex]);
    }
    const absl::Status status = mesh_.AddPolygon(corners);
    return absl::IsInvalidArgument(status) ? line.Fault(std::string(status.message())) : status;
  }

  // The index of a vertex from "7", "7/1", "7//3" or "7/1/3": counted from 1, or from the end if
  // negative.
  std::optional<std::size_t> VertexOf(std::string_view word) const {
    const std::string_view index = word.substr(0, word.find('/'));
    std::int64_t given = 0;
    if (!absl::SimpleAtoi({index.data(), index.size()}, &given)) return std::nullopt;
    const auto count = static_cast<std::int64_t>(vertices_.size());
    if (given == 0 || given > count || given < -count) return std::nullopt;
    return static_cast<std::size_t>(given > 0 ? given - 1 : count + given);
  }

  MeshBuilder mesh_;
  std::vector<Vector3> vertices_;
};

}  // namespace

absl::StatusOr<TriangleMesh> ReadObj(std::string_view bytes, const MeshFileLimits& limits) {
  return ObjReader(limits).Read(bytes);
}

}  // namespace cwm::collision
