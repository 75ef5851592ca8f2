// Blobs (meshes, labels) to and from the server, named by their SHA-256; objects' surfaces from it.
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

// DATA_LOSS when what arrives is not what the hash names.
absl::StatusOr<Blob> ReadGeometry(const Connection& connection, const std::string& hash);

struct Surface {
  formats::MeshFile mesh;          // in the object's frame
  cwm::v1::GeometryHeader header;  // of which revision, where the object is, how close the mesh is
};
// All that an object is made of as one mesh. DATA_LOSS when what arrives is not what the header's
// hash says.
absl::StatusOr<Surface> ReadSurface(const Connection& connection,
                                    const cwm::v1::ObjectSurface& object,
                                    const Progress& progress = {});

// Stores the blob and returns its hash; bytes that the server has already are sent once more and
// stored once. `progress` hears how much was handed to the connection.
absl::StatusOr<std::string> WriteGeometry(const Connection& connection, const Blob& blob,
                                          const Progress& progress = {});

// A blob of GEOMETRY_FORMAT_MESH_F64; mesh_bytes.h encodes one. INVALID_ARGUMENT when the bytes are
// no such mesh or a corner is no vertex.
absl::StatusOr<formats::MeshFile> DecodeMesh(std::string_view bytes);

}  // namespace cwm::client
