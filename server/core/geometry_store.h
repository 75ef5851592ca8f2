// Blobs by content: meshes and label images, named by the SHA-256 of their bytes, so that none
// travels twice.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/core/limits.h"

namespace cwm::server {

enum class BlobFormat { kMeshF64, kLabelsU32 };

struct Blob {
  BlobFormat format = BlobFormat::kMeshF64;
  std::string bytes;
  std::shared_ptr<const TriangleMesh> mesh;  // decoded, for kMeshF64
};

// InvalidArgument INVALID_FIELD when the bytes are not the encoding of mesh_bytes.h, or the mesh
// breaks a rule of validation.h (indices, finite, at least one triangle).
absl::StatusOr<TriangleMesh> DecodeMesh(std::string_view bytes);
// The hash of a mesh's encoding without keeping the encoding; cached by the mesh's address while it
// lives.
std::string HashOf(const std::shared_ptr<const TriangleMesh>& mesh);

// Thread safe. Blobs that clients or ingests stored are kept while an object of a kept revision
// uses their mesh, and otherwise the most recently used ones within a byte limit.
class GeometryStore {
 public:
  // `max_bytes` limits the memory of blobs that no object uses: their bytes and decoded meshes.
  explicit GeometryStore(std::int64_t max_bytes,
                         std::int64_t max_triangles = Limits{}.max_mesh_triangles);
  ~GeometryStore();

  struct Stored {
    std::string hash;
    bool already_known = false;
  };
  // InvalidArgument when a mesh blob is malformed or breaks a rule (indices, finite, triangles):
  // names field, value, rule. ResourceExhausted GEOMETRY_TOO_LARGE when it can never fit.
  absl::StatusOr<Stored> Put(BlobFormat format, std::string bytes);
  // Of a blob that is known: as if its bytes had come again. NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<Stored> PutAgain(BlobFormat format, std::string_view hash);
  // Makes the mesh of an object readable by its hash; holds it weakly.
  std::string Offer(const std::shared_ptr<const TriangleMesh>& mesh);
  // NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<std::shared_ptr<const Blob>> Get(std::string_view hash) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
