// The first frame of a sensor whose pose nothing tells: it is ingested as a scan, which estimates
// the pose.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>

#include "absl/status/statusor.h"
#include "server/core/ingest.h"
#include "server/core/live/live_frame.h"
#include "server/core/live/sensor_session.h"
#include "server/core/world.h"

namespace cwm::server {

// chosen: an attempt takes about a second of one core, so that a sensor which sees no table uses at
// most half of one.
inline constexpr auto kFirstFramePeriod = std::chrono::seconds(2);

// True if a frame that comes now has to be ingested: neither it nor the calibration tells the pose,
// the world keeps none, and no other frame failed to tell it within kFirstFramePeriod.
bool MustIngestFirst(const World& world, const SensorSession& session, bool frame_has_pose,
                     Clock::time_point now);

// Interprets a scan: an interpreter, and its threads as in perception::InterpretOptions.
struct ScanInterpreter {
  Interpreter interpret = {};
  int max_threads = 1;
  std::function<int()> threads_now = {};
};

// Estimates the sensor's pose if nothing tells it (z up, origin at the sensor), keeps it in the
// world as an estimate, and returns what the scan changed, which takes as long as a scan. Empty,
// with nothing done, for a frame with a pose. The errors of Ingest; FailedPrecondition
// SENSOR_POSE_UNKNOWN, with nothing written, if the frame does not confirm an estimate. A frame
// within kFirstFramePeriod of such an error gets it, too. Robots in view are taken for objects,
// since nothing tells yet where in the image they are.
absl::StatusOr<std::optional<FrameChanges>> IngestFirstFrame(World& world, SensorSession& session,
                                                             const LiveFrame& frame,
                                                             const ScanInterpreter& by,
                                                             std::stop_token stop);

}  // namespace cwm::server
