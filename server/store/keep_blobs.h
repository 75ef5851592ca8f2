// Stores what is too large for records, before the records that name it.
#pragma once

#include <span>
#include <string>

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "server/core/load_robot.h"
#include "server/store/store.h"

namespace cwm::server {

// Stores the large meshes (encode_shapes.h) of the models, unless they are there already. Ignores
// null pointers. The errors of Store::PutBlob.
absl::Status KeepGeometry(Store& store, std::span<const PreparedModelPtr> models,
                          Durability durability);

// Stores the robot's files and the list of them, all durably. Returns the hash of the list, which
// is that of equal files and settings. The errors of Store::PutBlob.
absl::StatusOr<std::string> KeepRobotFiles(Store& store, const RobotFiles& files);
// Reads what KeepRobotFiles stored. The errors of Store::GetBlob; DataLoss with the field for a
// list that is not valid.
absl::StatusOr<RobotFiles> ReadRobotFiles(const Store& store, const std::string& files_hash);

}  // namespace cwm::server
