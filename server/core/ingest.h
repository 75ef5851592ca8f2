// A scan into a world: interpret with no lock held, associate with the latest snapshot, publish one
// change.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/interpret_scene.h"
#include "server/core/world.h"

namespace cwm::server {

enum class IngestMode { kUpdate, kAdd, kSegmentOnly };

struct IngestRequest {
  perception::PointCloud cloud;
  std::string sensor;
  perception::InterpretOptions options;  // X_WC set when the sensor's pose was given
  IngestMode mode = IngestMode::kUpdate;
  std::chrono::system_clock::time_point frame_stamp;  // the clock's epoch: not known, now
  WriteOptions write;
};

struct IngestOutcome {
  collision::Revision revision;
  bool replayed = false;  // a retry: this is what the first try came to
  Pose X_WC = Pose::Identity();
  perception::InterpretReport report;
  // The world's objects behind the labels: supports, then objects in label order. Provisional ones
  // (of no world: uid empty, geometry with a model but no parts) for kSegmentOnly, and with an
  // empty name for what known geometry explains already (a user's, or a piece of a known object),
  // of which nothing is made.
  std::vector<collision::WorldObjectPtr> supports;
  std::vector<collision::WorldObjectPtr> objects;
  std::vector<std::optional<bool>> support_reachable;  // one per support
  std::vector<std::uint32_t> labels;
  // Names. Kept are those that the scan showed; what lies outside its view is not told.
  std::vector<std::string> added, moved, replaced, removed, kept, occluded;
};

// The interpreter is passed in, so that the core links no PCL and is tested on its own: it is
// perception::InterpretScene in the server.
using Interpreter = std::function<absl::StatusOr<perception::SceneInterpretation>(
    const perception::PointCloud&, const perception::InterpretOptions&, std::stop_token)>;

// At most one revision; none when nothing changed. InvalidArgument from the interpreter; the errors
// of World::Update; Cancelled when stopped, with nothing written; Aborted SENSOR_POSE_CHANGED when
// the sensor's pose was given anew again and again meanwhile. The sensor's pose is kept in the
// world: a given one replaces, an estimated one stays until one is given or an up that
// speaks against it; a guess is not kept.
// kSegmentOnly takes a kept pose when it was given, but no estimate of earlier scans.
absl::StatusOr<IngestOutcome> Ingest(World& world, const IngestRequest& request,
                                     const Interpreter& interpret, std::stop_token stop);

}  // namespace cwm::server
