// Watching a world: the initial state, then every change in the order of revisions. A cursor never
// delays a writer: the writer appends to the log and wakes the readers; each reader pulls at its
// own pace.
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
  enum class Kind { kInitialState, kEvents, kBookmark };
  Kind kind = Kind::kBookmark;
  collision::Revision revision;  // everything up to here is delivered, including this step
  // kInitialState: the whole world in `snapshot`. kEvents: the changes by name, i.e. the deltas of
  // one revision (lossless) or of all revisions since the last step (coalesced); an object or a
  // robot that was made anew under its name is a removal followed by an addition.
  SnapshotPtr snapshot = {};
  std::vector<collision::ObjectDelta> deltas = {};
  std::vector<collision::RobotDelta> robot_deltas = {};
  std::vector<collision::PairRuleDelta> rule_deltas = {};
  bool last = false;  // the world or the server is closing: no step follows
};

// Not thread safe: one reader. `wake` of World::Watch is called from writers' threads (without a
// lock of the world) whenever Next may have something new after it returned nothing. A call of
// `wake` may still be in progress, or about to begin, when the cursor is destroyed, so it must hold
// what it needs by a shared or weak pointer. It must not throw.
class WatchCursor {
 public:
  virtual ~WatchCursor() = default;
  // The next step; empty if the reader is up to date. ResourceExhausted WATCH_TOO_SLOW if a
  // lossless reader fell behind the kept events; NotFound WORLD_DELETED after the world's end, once
  // all events before it were delivered. A draining server ends the watch with a bookmark that is
  // `last`, after which nothing follows. A coalesced bookmark that is not `last` says that the
  // revision advanced while objects, robots and pair rules are unchanged.
  virtual absl::StatusOr<std::optional<WatchStep>> Next() = 0;
  // The revision that the reader has reached, for idle bookmarks.
  virtual collision::Revision position() const = 0;
};

}  // namespace cwm::server
