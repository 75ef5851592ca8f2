// GEOMETRY_FORMAT_MESH_F64: uint32 vertex_count, uint32 triangle_count, vertices 3 x f64, triangles
// 3 x uint32, little-endian. This is the only definition of how a mesh travels and is hashed.
//
// It works on every mesh whose `vertices` are vectors of three doubles and whose `triangles` are
// vectors of three uint32, contiguous in memory.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"

namespace cwm {

struct MeshCounts {
  std::uint32_t vertices = 0;
  std::uint32_t triangles = 0;
};

inline constexpr std::size_t kMeshCountsBytes = 2 * sizeof(std::uint32_t);
inline constexpr std::size_t kVertexBytes = 3 * sizeof(double);
inline constexpr std::size_t kTriangleBytes = 3 * sizeof(std::uint32_t);

// Returns the counts in the header of a blob. InvalidArgument, "has N bytes, must have ...", if its
// size does not match them.
absl::StatusOr<MeshCounts> ReadMeshCounts(std::string_view bytes);

// Calls sink(data, size) for the pieces of the encoding, in order, so that it can be hashed without
// a copy.
template <class Mesh, class Sink>
void ForEachMeshPiece(const Mesh& mesh, const Sink& sink) {
  static_assert(std::endian::native == std::endian::little, "columns travel as they lie in memory");
  static_assert(sizeof(mesh.vertices[0]) == kVertexBytes);
  static_assert(sizeof(mesh.triangles[0]) == kTriangleBytes);
  const std::array<std::uint32_t, 2> counts = {static_cast<std::uint32_t>(mesh.vertices.size()),
                                               static_cast<std::uint32_t>(mesh.triangles.size())};
  sink(counts.data(), kMeshCountsBytes);
  sink(mesh.vertices.data(), mesh.vertices.size() * kVertexBytes);
  sink(mesh.triangles.data(), mesh.triangles.size() * kTriangleBytes);
}

template <class Mesh>
std::string EncodeMesh(const Mesh& mesh) {
  std::string bytes;
  bytes.reserve(kMeshCountsBytes + mesh.vertices.size() * kVertexBytes +
                mesh.triangles.size() * kTriangleBytes);
  ForEachMeshPiece(mesh, [&](const void* data, std::size_t size) {
    bytes.append(static_cast<const char*>(data), size);
  });
  return bytes;
}

// Decodes the columns of a mesh. The caller checks that triangle indices are valid and coordinates
// finite. InvalidArgument as in ReadMeshCounts.
template <class Mesh>
absl::StatusOr<Mesh> ReadMeshColumns(std::string_view bytes) {
  const absl::StatusOr<MeshCounts> counts = ReadMeshCounts(bytes);
  if (!counts.ok()) return counts.status();
  Mesh mesh;
  static_assert(sizeof(mesh.vertices[0]) == kVertexBytes);
  static_assert(sizeof(mesh.triangles[0]) == kTriangleBytes);
  mesh.vertices.resize(counts->vertices);
  mesh.triangles.resize(counts->triangles);
  const char* const data = bytes.data() + kMeshCountsBytes;
  const std::size_t vertex_bytes = counts->vertices * kVertexBytes;
  if (counts->vertices > 0) {
    std::memcpy(static_cast<void*>(mesh.vertices.data()), data, vertex_bytes);
  }
  if (counts->triangles > 0) {
    std::memcpy(static_cast<void*>(mesh.triangles.data()), data + vertex_bytes,
                counts->triangles * kTriangleBytes);
  }
  return mesh;
}

}  // namespace cwm
