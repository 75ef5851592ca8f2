// Ingests a scan into a world: interprets it without a lock, associates it with the latest snapshot
// and publishes one change.
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
  perception::PointCloud cloud;  // its origin is viewpoint_C, its axes are those of frame C
  Vector3 viewpoint_C = Vector3::Zero();  // in the frame C of the sender's points
  std::string sensor;
  perception::InterpretOptions options;  // X_WC is set if the pose of C was given
  bool in_world_frame = false;           // C is the world's frame, and tells no sensor's pose
  bool force = false;                    // takes a scan that contradicts the world
  // The pose of the sensor that the world keeps, if it is not that of the options.
  std::optional<SensorPose> kept_pose = {};
  // Refuses a scan whose pose would only be a guess.
  bool needs_confirmed_pose = false;
  IngestMode mode = IngestMode::kUpdate;
  std::chrono::system_clock::time_point frame_stamp;  // the epoch means unknown: now is used
  WriteOptions write;

  std::chrono::system_clock::time_point taken_at() const {
    const bool is_stamped = frame_stamp != std::chrono::system_clock::time_point();
    return is_stamped ? frame_stamp : std::chrono::system_clock::now();
  }
};

struct IngestOutcome {
  collision::Revision revision;
  bool replayed = false;  // a retry: this is the outcome of the first try
  // The scan shows what its sensor saw when its view was interpreted: these are the known objects,
  // and nothing was interpreted.
  bool unchanged_view = false;
  Pose X_WC = Pose::Identity();  // of the frame of the sender's points
  perception::InterpretReport report;
  // The world's objects behind the labels: supports, then objects in label order. For kSegmentOnly
  // they are provisional objects that belong to no world (empty uid, geometry with a model but no
  // parts); their name is empty if known geometry explains them already (a user's object, or a part
  // of a known object), so that no object would be made.
  std::vector<collision::WorldObjectPtr> supports;
  std::vector<collision::WorldObjectPtr> objects;
  std::vector<std::optional<bool>> support_reachable;  // one per support
  std::vector<std::uint32_t> labels;
  // Names. `kept` has the objects that the scan showed; objects outside its view are not listed.
  std::vector<std::string> added, moved, replaced, removed, kept, occluded;
};

// The interpreter is passed in, so that the core does not link PCL and is tested on its own. The
// server passes perception::InterpretScene.
using Interpreter = std::function<absl::StatusOr<perception::SceneInterpretation>(
    const perception::PointCloud&, const perception::InterpretOptions&, std::stop_token)>;

// Publishes at most one revision; none if nothing changed. A scan of a view that did not change
// since the last one was interpreted (unchanged_view.h) is not interpreted, unless the request has
// `force` or only segments: its objects were seen again. InvalidArgument from the interpreter; the
// errors of World::Update; FailedPrecondition SCAN_CONTRADICTS_WORLD (scan_plausibility.h) unless
// forced, SENSOR_POSE_UNKNOWN for a guessed pose if the request needs a confirmed one; Cancelled
// when stopped, with nothing written; Aborted SENSOR_POSE_CHANGED if the sensor's pose changed again and again meanwhile. The sensor's pose is
// kept in the world: a given pose replaces the kept one; an estimated pose stays until a pose is
// given or an up direction contradicts it; a guess is not kept. kSegmentOnly uses a kept pose only
// if it was given, not an estimate of earlier scans.
absl::StatusOr<IngestOutcome> Ingest(World& world, const IngestRequest& request,
                                     const Interpreter& interpret, std::stop_token stop);

}  // namespace cwm::server
