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
  std::chrono::system_clock::time_point frame_stamp;
  WriteOptions write;
};

struct IngestOutcome {
  collision::Revision revision;
  Pose X_WC = Pose::Identity();
  perception::InterpretReport report;
  // The world's objects behind the labels: supports, then objects in label order; provisional ones
  // for kSegmentOnly.
  std::vector<collision::WorldObjectPtr> supports;
  std::vector<collision::WorldObjectPtr> objects;
  std::vector<std::optional<bool>> support_reachable;  // one per support
  std::vector<std::uint32_t> labels;
  std::vector<std::string> added, moved, replaced, removed, kept, occluded;  // names
};

// The interpreter is passed in, so that the core links no PCL and is tested on its own: it is
// perception::InterpretScene in the server.
using Interpreter = std::function<absl::StatusOr<perception::SceneInterpretation>(
    const perception::PointCloud&, const perception::InterpretOptions&, std::stop_token)>;

absl::StatusOr<IngestOutcome> Ingest(World& world, const IngestRequest& request,
                                     const Interpreter& interpret, std::stop_token stop);

}  // namespace cwm::server
