// PLY; declared in drawn_world.h.
#include <bit>

#include "absl/strings/str_cat.h"
#include "server/export/drawn_world.h"
#include "server/export/file_bytes.h"

namespace cwm::server {
namespace {

std::string Header(const DrawnWorld& world, std::size_t vertices, std::size_t triangles) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  absl::StrAppend(&text, "comment world ", world.name, ", metres, z up\n");
  for (std::size_t i = 0; i < world.items.size(); ++i) {
    const DrawnItem& item = world.items[i];
    absl::StrAppend(&text, "comment thing ", i, " ", item.robot, item.robot.empty() ? "" : "/",
                    item.name, "\n");
  }
  absl::StrAppend(&text, "element vertex ", vertices,
                  "\nproperty double x\nproperty double y\nproperty double z\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\n");
  absl::StrAppend(&text, "element face ", triangles,
                  "\nproperty list uchar uint vertex_indices\nproperty uint thing\nend_header\n");
  return text;
}

}  // namespace

absl::StatusOr<std::string> FormatPly(const DrawnWorld& world,
                                      const CancellationCheck& check_cancelled) {
  std::size_t vertices = 0, triangles = 0;
  for (const DrawnItem& item : world.items) {
    for (const DrawnMesh& piece : *item.body) {
      vertices += piece.mesh.vertices.size();
      triangles += piece.mesh.triangles.size();
    }
  }
  std::string bytes = Header(world, vertices, triangles);
  constexpr std::size_t kVertexBytes = 27, kFaceBytes = 17;
  bytes.reserve(bytes.size() + kVertexBytes * vertices + kFaceBytes * triangles);
  for (const DrawnItem& item : world.items) {
    for (const DrawnMesh& piece : *item.body) {
      const auto colour = ColourOf(piece.material);
      const auto append = [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
          const Vector3 p_W = item.X_WB * piece.mesh.vertices[v];
          for (int i = 0; i < 3; ++i) AppendBytes(p_W[i], bytes);
          for (std::size_t i = 0; i < 3; ++i) AppendBytes(colour[i], bytes);
        }
      };
      const absl::Status status = ForEachRange(piece.mesh.vertices.size(), check_cancelled, append);
      if (!status.ok()) return status;
    }
  }
  std::uint32_t first = 0, number = 0;
  for (const DrawnItem& item : world.items) {
    for (const DrawnMesh& piece : *item.body) {
      const auto append = [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
          AppendBytes(std::uint8_t{3}, bytes);
          for (const std::uint32_t vertex : piece.mesh.triangles[t]) {
            AppendBytes(first + vertex, bytes);
          }
          AppendBytes(number, bytes);
        }
      };
      const absl::Status status =
          ForEachRange(piece.mesh.triangles.size(), check_cancelled, append);
      if (!status.ok()) return status;
      first += static_cast<std::uint32_t>(piece.mesh.vertices.size());
    }
    ++number;
  }
  return bytes;
}

}  // namespace cwm::server
