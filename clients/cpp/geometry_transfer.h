// Transfers blobs (meshes, labels) by their SHA-256, and reads objects' surfaces.
#pragma once

#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/progress.h"
#include "clients/formats/mesh_file.h"

namespace cwm::client {

struct Blob {
  cwm::v1::GeometryFormat format = cwm::v1::GEOMETRY_FORMAT_MESH_F64;
  std::string bytes;
};

// DATA_LOSS if the received bytes do not match the hash.
absl::StatusOr<Blob> ReadGeometry(const Connection& connection, const std::string& hash);

struct Surface {
  formats::MeshFile mesh;          // in the object's frame
  cwm::v1::GeometryHeader header;  // its revision, the object's pose, the mesh's deviation
};
// The object's full surface as one mesh. DATA_LOSS if the received bytes do not match the header's
// hash.
absl::StatusOr<Surface> ReadSurface(const Connection& connection,
                                    const cwm::v1::ObjectSurface& object,
                                    const Progress& progress = {});

// Stores the blob and returns its hash. Bytes that the server has already are sent again and stored
// once. `progress` counts bytes passed to the connection.
absl::StatusOr<std::string> WriteGeometry(const Connection& connection, const Blob& blob,
                                          const Progress& progress = {});

// Decodes a blob of GEOMETRY_FORMAT_MESH_F64; mesh_bytes.h encodes one. INVALID_ARGUMENT if the
// bytes are not such a mesh or a corner is not a vertex.
absl::StatusOr<formats::MeshFile> DecodeMesh(std::string_view bytes);

}  // namespace cwm::client
