// Tells whether a scan shows what its sensor saw when its view was interpreted, in which case the
// known objects are the answer.
#pragma once

#include <memory>
#include <optional>

#include "server/core/ingest.h"
#include "server/core/kept_views.h"

namespace cwm::server {

// The world that a scan was matched with, that its changes were applied to, and after them.
struct SnapshotsOfScan {
  SnapshotPtr matched = {}, changed = {}, after = {};
};

// The view of a scan that was interpreted with `pose`; `report` is the interpreter's. nullptr if no
// later scan may be compared with it: it has too many points, or others changed an object in the
// view after the scan was matched.
KeptViewPtr MakeKeptView(const IngestRequest& request, const SensorPose& pose,
                         const IngestOutcome& outcome, const perception::InterpretReport& report,
                         const SnapshotsOfScan& worlds);

// The reply to the scan, without revision and stages, if it shows the view unchanged, and the world
// is in the view as it was then. Empty if anything differs or may differ: the conditions of the
// interpretation, an object that is or was in the view, what was measured (still_view.h), an object
// of which less than half the points are left, or more than 0.5 % of points without a surface
// nearby that had a label. The scan is always compared with the one that was interpreted, so that
// small changes add up.
std::optional<IngestOutcome> MatchUnchanged(const KeptView& view, const IngestRequest& request,
                                            const SensorPose& pose,
                                            const collision::WorldSnapshot& world);

// True if all objects in the view are those of the view, in the same places and shapes.
bool HoldsAsSeen(const collision::WorldSnapshot& world, const KeptView& view);

// The facts that an ingest of the unchanged view tells: its objects were seen again.
WriteFacts SightingsOf(const KeptView& view, const IngestRequest& request);

}  // namespace cwm::server
