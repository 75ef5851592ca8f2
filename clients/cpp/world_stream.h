// Worlds of <cwm/world.h> for programs that have a connection and messages already.
#pragma once

#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "clients/cpp/connection.h"
#include "clients/cpp/row_bytes.h"
#include "cwm/v1/geometry.pb.h"
#include "cwm/v1/world.pb.h"
#include "cwm/world.h"

namespace cwm::client {

// One revision of a world.
struct WorldRevision {
  std::string world = {};  // empty: "default"
  std::string world_uid = {};
  std::int64_t revision = 0;
};

// Queries about the revision over a stream of the connection, answered as if these changes had been
// made. The server has the meshes that they name.
absl::StatusOr<api::WorldView> StreamWorld(
    const Connection& connection, const WorldRevision& at,
    const google::protobuf::RepeatedPtrField<v1::Change>& overlay);

// Poses whose quaternions are of unit length; an absent pose is the identity.
Eigen::Isometry3d ToIsometry(const v1::Pose& pose);
Eigen::Isometry3d ToIsometry(const PoseRow& row);

}  // namespace cwm::client
