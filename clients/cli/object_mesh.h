// Everything that an object is made of as one mesh.
#pragma once

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/formats/mesh_file.h"
#include "cwm/v1/world.pb.h"

namespace cwm::cli {

// What collision checking sees of the object, in the world's frame: its shapes tessellated to
// within half a millimetre (Tessellate), its surfaces, its handles (one without a mesh as its box).
// Parts that touch or overlap keep their own vertices. Asks the server for the meshes that the
// object names by hash; NOT_FOUND when there is nothing to show.
absl::StatusOr<formats::MeshFile> MeshOf(const client::Connection& connection,
                                         const cwm::v1::Object& object);

}  // namespace cwm::cli
