// The changes of one frame as a write of the world, object by object.
#pragma once

#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/live/tracker.h"
#include "server/core/live/body_table.h"
#include "server/core/live/live_frame.h"
#include "server/core/world.h"

namespace cwm::server {

// The objects of kind kMover in a world, by the sensor that sees them. Their names are places in a
// list: mover_1, mover_2 and so on. Not thread safe.
class MoverObjects {
 public:
  // The objects of these pieces, with their geometry made. Pieces that are what the sensor had
  // before make none.
  struct Plan {
    std::string sensor = {};
    std::vector<collision::PutObject> puts = {};  // one per piece; without names
  };
  static Plan PlanOf(const std::string& sensor, std::span<const perception::MoverPiece> pieces);

  // Under the writer's turn: the changes that make the world hold the planned pieces in place of
  // the sensor's previous ones. Names that others took meanwhile are passed over.
  std::vector<collision::Change> Changes(const Plan& plan, const collision::WorldSnapshot& latest);
  // The changes were published: `names` are the sensor's movers from now on.
  void Set(const std::string& sensor, std::vector<std::string> names);

 private:
  std::map<std::string, std::vector<std::string>> names_;  // by sensor
};

// Changes that remove whatever movers the world holds: those of before a restart.
std::vector<collision::Change> RemoveMovers(const collision::WorldSnapshot& latest);

struct LiveWrite {
  std::shared_ptr<const BodyTable> bodies = {};  // that the frame was compared with
  std::span<const perception::TrackChange> changes = {};
  std::string sensor = {};
  bool takes_robot_states = false;
};

struct LiveWritten {
  collision::Revision revision = {};
  FrameChanges changes = {};
  std::vector<collision::WorldObjectPtr> removed = {};  // as they were
};

// Publishes at most one revision, none if nothing has an effect. An object that was changed,
// removed or attached since the frame was compared is left as it is, as is one that a user owns.
// The errors of World::Update.
absl::StatusOr<LiveWritten> Commit(World& world, const LiveWrite& write, MoverObjects& movers);

}  // namespace cwm::server
