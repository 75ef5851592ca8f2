// Blobs by content: meshes, label images and points, named by the SHA-256 of their bytes, so that
// none travels twice. And the full surfaces of objects, made when they are read.
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

// A blob that is let go with the last copy of its hold.
struct HeldBlob {
  std::string hash;
  std::shared_ptr<const void> hold;
};

struct Blob {
  BlobFormat format = BlobFormat::kMeshF64;
  std::shared_ptr<const std::string> bytes;  // never null
  std::shared_ptr<const TriangleMesh> mesh;  // decoded, for kMeshF64
};

// InvalidArgument INVALID_FIELD when the bytes are not the encoding of mesh_bytes.h, or the mesh
// breaks a rule of validation.h (indices, finite, at least one triangle).
// Ends with the budget: a mesh of millions of triangles takes some tenths of a second.
absl::StatusOr<TriangleMesh> DecodeMesh(std::string_view bytes, WorkBudget* budget = nullptr);
// SHA-256 of the bytes, in lower-case hex; void where the budget ended.
std::string HashOf(std::string_view bytes, WorkBudget* budget);
// The hash of a mesh's encoding without keeping the encoding; cached by the mesh's address while it
// lives.
std::string HashOf(const std::shared_ptr<const TriangleMesh>& mesh);

// Thread safe. Blobs that clients or ingests stored are kept while an object of a kept revision
// uses their mesh, and otherwise the most recently used ones within a byte limit. What objects use
// is encoded when somebody reads it; limits.encoded_mesh_bytes of that are kept for later readers.
class GeometryStore {
 public:
  // `max_bytes` limits the memory of blobs that no object uses: their bytes and decoded meshes.
  explicit GeometryStore(std::int64_t max_bytes, const Limits& limits = {});
  ~GeometryStore();

  struct Stored {
    std::string hash;
    bool already_known = false;
  };
  // InvalidArgument when a mesh blob is malformed or breaks a rule (indices, finite, triangles):
  // names field, value, rule. ResourceExhausted GEOMETRY_TOO_LARGE when it can never fit.
  absl::StatusOr<Stored> Put(BlobFormat format, std::string bytes, WorkBudget* budget = nullptr);
  // As Put, of what is of use for a while: let go with the last hold, unless others put the same
  // bytes meanwhile; sooner where more recently used ones need the room.
  absl::StatusOr<HeldBlob> PutForHolder(BlobFormat format, std::string bytes);
  // Of a blob that is known: as if its bytes had come again. NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<Stored> PutAgain(BlobFormat format, std::string_view hash,
                                  WorkBudget* budget = nullptr);
  // Makes the mesh of an object readable by its hash; holds it weakly.
  std::string Offer(const std::shared_ptr<const TriangleMesh>& mesh);
  // NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<std::shared_ptr<const Blob>> Get(std::string_view hash) const;
  // The mesh alone, which takes a look-up: nothing is encoded. NotFound GEOMETRY_UNKNOWN.
  absl::StatusOr<StoredMesh> FindMesh(std::string_view hash) const;
  // The full surface of an object's model (full_surface.h), in the object's frame. Heavy where it
  // is not kept: no lock may be held. FailedPrecondition SURFACE_UNBOUNDED, ResourceExhausted
  // GEOMETRY_TOO_LARGE.
  absl::StatusOr<std::shared_ptr<const EncodedMesh>> SurfaceOf(
      const std::shared_ptr<const collision::PreparedModel>& model,
      WorkBudget* budget = nullptr) const;
  // Lets go of meshes that objects used and no longer do, before others need their room: for when
  // worlds go.
  void ForgetUnused();
  // Meshes and surfaces that were encoded because none was kept.
  std::int64_t encoded_count() const;

 private:
  struct State;
  // The number under which the store holds what was put.
  absl::StatusOr<std::uint64_t> Put(BlobFormat format, std::string bytes, Stored& stored,
                                    WorkBudget* budget);

  std::shared_ptr<State> state_;  // holds may outlive the store
};

}  // namespace cwm::server
