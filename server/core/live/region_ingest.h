// Interprets a part of a sensor's view beside its frames, and brings the world up to it.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/live/tracker.h"
#include "server/core/ingest.h"
#include "server/core/live/body_table.h"
#include "server/core/live/live_frame.h"
#include "server/core/world.h"

namespace cwm::server {

struct RegionJob {
  std::string sensor;
  Pose X_WC_given = Pose::Identity();  // the frame's pose, before others corrected it
  perception::RegionRequest request;
  perception::FrameEvidence frame;          // that the tracker asked about
  std::shared_ptr<const BodyTable> bodies;  // that the frame was compared with
  // Objects that frames removed lately. A thing that looks like one of them is that thing: it comes
  // back under its name.
  std::vector<collision::WorldObjectPtr> gone = {};
  int max_threads = 1;
  std::function<int()> threads_now = {};  // as in perception::InterpretOptions
};

// The blocks of a request that are as they were when it was made; asked once it was interpreted.
using SameSince = std::function<std::vector<std::int32_t>(const RegionJob& job)>;

struct RegionOutcome {
  collision::Revision revision = {};  // of the world afterwards
  FrameChanges changes = {};
  // Those of `gone` that came back, as they were; in changes.added.
  std::vector<collision::WorldObjectPtr> returned = {};
  // Those that show what was not taken into the world, ascending: what reaches out of the view of a
  // new surface (perception::NewSurfaces), and what has changed since.
  std::vector<std::int32_t> open_blocks = {};
};

// Publishes at most one revision. A new surface may add objects, and parts to supports and
// residuals (`replaced`), which keep their poses. Else only the bodies of the request may move,
// change or vanish; supports stay, though new ones may be added; and what was found in blocks that
// have changed since says nothing: it may have left, and is asked for again if it rests. An object
// that was changed otherwise meanwhile is left as it is. The errors of the interpreter and of
// World::Update; Cancelled when stopped.
absl::StatusOr<RegionOutcome> IngestRegion(World& world, const RegionJob& job,
                                           const Interpreter& interpret,
                                           const SameSince& same_since, std::stop_token stop);

}  // namespace cwm::server
