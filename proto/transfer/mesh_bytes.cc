#include "proto/transfer/mesh_bytes.h"

#include "absl/strings/str_cat.h"

namespace cwm {

absl::StatusOr<MeshCounts> ReadMeshCounts(std::string_view bytes) {
  if (bytes.size() < kMeshCountsBytes) {
    return absl::InvalidArgumentError(absl::StrCat(
        "has ", bytes.size(), " bytes, must have at least ", kMeshCountsBytes, " for its header"));
  }
  MeshCounts counts;
  std::memcpy(&counts.vertices, bytes.data(), sizeof(counts.vertices));
  std::memcpy(&counts.triangles, bytes.data() + sizeof(counts.vertices), sizeof(counts.triangles));
  const std::uint64_t expected = kMeshCountsBytes + std::uint64_t{counts.vertices} * kVertexBytes +
                                 std::uint64_t{counts.triangles} * kTriangleBytes;
  if (bytes.size() == expected) return counts;
  return absl::InvalidArgumentError(absl::StrCat("has ", bytes.size(), " bytes, must have ",
                                                 expected, " for ", counts.vertices,
                                                 " vertices and ", counts.triangles, " triangles"));
}

}  // namespace cwm
