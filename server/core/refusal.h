// Errors of collision::Apply as a client is told them.
#pragma once

#include <span>
#include <string>

#include "absl/status/status.h"
#include "collision/world/world_snapshot.h"

namespace cwm::server {

// Adds reason and details to a status of collision::Apply, as documented at World::Apply; `list` is
// the request's field that held the changes.
absl::Status ExplainRefusal(const absl::Status& status, const collision::WorldSnapshot& base,
                            std::span<const collision::Change> changes, const std::string& list);

}  // namespace cwm::server
