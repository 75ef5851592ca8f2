// Makes worlds of what was folded: the steps from messages to values, on all cores.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_limits.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/world_image.h"
#include "server/store/decode_values.h"
#include "server/store/prepare_geometry.h"
#include "server/store/store.h"
#include "server/store/world_fold.h"

namespace cwm::server {

// A world after all its records, and the events of the newest ones that are kept.
struct FoldedWorld {
  explicit FoldedWorld(WorldFold f) : fold(std::move(f)) {}
  WorldFold fold;
  std::deque<FoldedEvent> events;  // the last led to the state of `fold`
};

struct ImageOptions {
  Retention retention = {};
  collision::RobotLimits robot_limits = {};
  int threads = 1;
  ClockPair now = {};
  // The clock by which allowances end: not behind any record, so that a clock that was set back
  // lengthens none.
  ClockPair rules_clock = {};
  AcceptedLosses accepted = {};
  std::shared_ptr<MemoryBudget> memory = {};  // charged with the geometry; may be null
  // Gets the share that is done, from 0 to 1, from any thread, one at a time.
  std::function<void(double share)> progress = {};
};

struct MadeWorld {
  WorldImage image;
  // Objects and robots of the newest revision whose content is lost: the image lacks them.
  std::vector<std::string> lost_objects = {}, lost_robots = {};
  // Objects that were attached to such a robot, as they are now: where they were, without the
  // attachment and without their models.
  std::vector<store::v1::Object> detached_objects = {};
  // Such content was in some kept revision. The image has the newest revision alone.
  bool has_losses = false;
};

struct MadeWorlds {
  std::vector<MadeWorld> worlds = {};  // in the order given
  std::int64_t geometry_count = 0;     // distinct geometries of objects and robots
};
// DataLoss STORE_DAMAGED with the place for what is not valid; the errors of Store::GetBlob.
absl::StatusOr<MadeWorlds> MakeWorlds(const Store& store, std::vector<FoldedWorld> worlds,
                                      const ImageOptions& options);

}  // namespace cwm::server
