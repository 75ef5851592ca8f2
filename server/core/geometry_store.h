// Blobs by content: meshes, label images and points, named by the SHA-256 of their bytes, so that
// none is sent twice. Also the full surfaces of objects, which are made when they are read.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/geometry/triangle_mesh.h"
#include "collision/world/world_object.h"
#include "proto/transfer/mesh_bytes.h"
#include "server/core/encoded_meshes.h"
#include "server/core/limits.h"
#include "server/core/mesh_facts.h"
#include "server/core/work_budget.h"

namespace cwm::server {

enum class BlobFormat { kMeshF64, kLabelsU32, kPointsF32 };

// A blob that is dropped with the last copy of its hold.
struct HeldBlob {
  std::string hash;
  std::shared_ptr<const void> hold;
};

struct Blob {
  BlobFormat format = BlobFormat::kMeshF64;
  std::shared_ptr<const std::string> bytes;  // never null
  std::shared_ptr<const TriangleMesh> mesh;  // decoded, for kMeshF64
};

// InvalidArgument INVALID_FIELD if the bytes are not the encoding of mesh_bytes.h, or if the mesh
// breaks a rule of validation.h (indices, finite, at least one triangle). Ends with the budget's
// status when the budget is spent: a mesh of millions of triangles takes some tenths of a second.
absl::StatusOr<TriangleMesh> DecodeMesh(std::string_view bytes, WorkBudget* budget = nullptr);
// SHA-256 of the bytes in lower-case hex; invalid if the budget ended.
std::string HashOf(std::string_view bytes, WorkBudget* budget);
// SHA-256 of the mesh's encoding, without keeping the encoding; cached by the mesh's address while
// it lives.
std::string HashOf(const std::shared_ptr<const TriangleMesh>& mesh);

// Thread safe. Blobs stored by clients or ingests are kept while an object of a kept revision uses
// their mesh; of the others the most recently used ones are kept within a byte limit. Meshes that
// only objects hold are encoded when they are read; limits.encoded_mesh_bytes of the encodings are
// kept for later readers.
class GeometryStore {
 public:
  // `max_bytes` limits the memory of blobs that no object uses: their bytes and decoded meshes.
  explicit GeometryStore(std::int64_t max_bytes, const Limits& limits = {});
  ~GeometryStore();

  struct Stored {
    std::string hash;
    bool already_known = false;
  };
  // InvalidArgument if a mesh blob is malformed or breaks a rule (indices, finite, triangles), with
  // field, value and rule. ResourceExhausted GEOMETRY_TOO_LARGE if it can never fit.
  absl::StatusOr<Stored> Put(BlobFormat format, std::string bytes, WorkBudget* budget = nullptr);
  // Like Put, for temporary blobs: dropped with the last hold unless others put the same bytes
  // meanwhile; sooner if more recently used blobs need the memory.
  absl::StatusOr<HeldBlob> PutTemporary(BlobFormat format, std::string bytes);
  // Like Put of a known blob's bytes. NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<Stored> Renew(BlobFormat format, std::string_view hash,
                               WorkBudget* budget = nullptr);
  // Makes the mesh of an object readable by its hash; holds it weakly.
  std::string RegisterMesh(const std::shared_ptr<const TriangleMesh>& mesh);
  // The same; a shape that names the hash while an object has the mesh gets its caps too.
  std::string RegisterMesh(const Mesh& solid);
  // NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<std::shared_ptr<const Blob>> Get(std::string_view hash) const;
  // Only the mesh, which is a look-up: nothing is encoded. NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<StoredMesh> FindMesh(std::string_view hash) const;
  // The full surface of an object's model (full_surface.h), in the object's frame. Heavy if it is
  // not kept, so no lock may be held. FailedPrecondition SURFACE_UNBOUNDED, ResourceExhausted
  // GEOMETRY_TOO_LARGE.
  absl::StatusOr<std::shared_ptr<const EncodedMesh>> SurfaceOf(
      const std::shared_ptr<const collision::PreparedModel>& model,
      WorkBudget* budget = nullptr) const;
  // Drops meshes that objects used and no longer use before their memory is needed; called when
  // worlds are deleted.
  void DropUnused();
  // Number of meshes and surfaces encoded because no encoding was kept.
  std::int64_t encoded_count() const;

 private:
  struct State;
  // Returns the number that identifies this period of holding the blob.
  absl::StatusOr<std::uint64_t> Put(BlobFormat format, std::string bytes, Stored& stored,
                                    WorkBudget* budget);

  std::shared_ptr<State> state_;  // shared, since holds may outlive the store
};

}  // namespace cwm::server
