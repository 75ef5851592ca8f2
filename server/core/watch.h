// Watching a world: initial state, then every change in the order of revisions. Cursors never hold
// a writer up: a writer appends to the log and wakes; each reader pulls at its own pace.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"

namespace cwm::server {

using SnapshotPtr = std::shared_ptr<const collision::WorldSnapshot>;

enum class WatchMode { kLossless, kCoalesced };

struct WatchOptions {
  std::optional<collision::Revision> from_revision = {};  // absent: initial state first
  WatchMode mode = WatchMode::kLossless;
};

// One step of a watch.
struct WatchStep {
  enum class What { kInitialState, kEvents, kBookmark };
  What what = What::kBookmark;
  collision::Revision revision;  // everything up to it has been delivered, this step included
  // kInitialState: the whole world in `snapshot`. kEvents: what changed, deltas of one revision
  // (lossless) or of all since the last step (coalesced), by name; an object or a robot that was
  // made anew under its name is a removal followed by an addition.
  SnapshotPtr snapshot = {};
  std::vector<collision::ObjectDelta> deltas = {};
  std::vector<collision::RobotDelta> robot_deltas = {};
  std::vector<collision::PairRuleDelta> rule_deltas = {};
  bool last = false;  // the world or the server is closing: no step follows
};

// Not thread safe itself: one reader. `wake` of World::Watch is called from writers' threads (no
// lock of the world held) whenever Next may have something new after it returned nothing. A call of
// `wake` may still be under way, or about to begin, when the cursor is destroyed: let it hold what
// it needs by a shared or weak pointer. It must not throw.
class WatchCursor {
 public:
  virtual ~WatchCursor() = default;
  // The next step, or nothing when the reader is up to date. ResourceExhausted WATCH_TOO_SLOW when
  // a lossless reader fell behind what is kept; NotFound WORLD_DELETED after the world's end, once
  // all events before it have been delivered. A draining server ends the watch with a bookmark that
  // is `last`, after which there is nothing. A bookmark that is not last says that the revision
  // moved on and objects, robots and rules of pairs are as they were (coalesced).
  virtual absl::StatusOr<std::optional<WatchStep>> Next() = 0;
  // Where the reader stands: for idle bookmarks.
  virtual collision::Revision position() const = 0;
};

}  // namespace cwm::server
