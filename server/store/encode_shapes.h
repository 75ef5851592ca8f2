// Writes the geometry of objects as messages of a store, bit by bit.
#pragma once

#include <cstdint>
#include <set>
#include <string>

#include "collision/geometry/hybrid_model.h"
#include "cwm/store/v1/record.pb.h"

namespace cwm::server {

// chosen: a mesh whose encoding (mesh_bytes.h) has so many bytes is a blob, smaller ones are part
// of their record. Below it a file costs more than the bytes.
inline constexpr std::int64_t kMinBlobBytes = 64 << 10;

// The bytes of the mesh's encoding.
std::int64_t EncodedBytes(const TriangleMesh& mesh);
inline bool IsBlob(const TriangleMesh& mesh) { return EncodedBytes(mesh) >= kMinBlobBytes; }

// Hashes of the blobs that messages name, each once.
using BlobHashes = std::set<std::string>;

store::v1::Pose EncodePose(const Pose& X_AB);
// Adds the hashes of large meshes to `blobs`.
store::v1::Model EncodeModel(const HybridModel& model, BlobHashes& blobs);

}  // namespace cwm::server
