// Turns one interpreted scan into one list of changes: what to put, move and remove so that the
// world matches what the sensor saw and nothing else changes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/world/world_snapshot.h"
#include "perception/interpret_scene.h"
#include "perception/track/association.h"
#include "server/core/ingest.h"

namespace cwm::server {

// A scene's detections under one index: its supports, then its objects.
class Detections {
 public:
  explicit Detections(const perception::SceneInterpretation& scene) : scene_(scene) {}

  int supports() const { return static_cast<int>(scene_.supports.size()); }
  int size() const { return supports() + static_cast<int>(scene_.objects.size()); }
  // The association's detection, or -1 if it concerns only a known object.
  int DetectionOf(const perception::Association& association) const;

  const Pose& X_WO(int detection) const;
  const std::shared_ptr<const HybridModel>& model(int detection) const;
  collision::ObjectKind kind(int detection) const;
  // The detection that supports this one, a support or another object, or -1.
  int supported_by(int detection) const;

 private:
  const perception::SceneInterpretation& scene_;
};

// The associations of a scan with one snapshot.
struct SceneMatch {
  SnapshotPtr snapshot;
  std::vector<collision::WorldObjectPtr> known;  // indexed by the associations' `known`
  std::vector<perception::Association> associations;
};
SceneMatch MatchScene(SnapshotPtr snapshot, const perception::SceneInterpretation& scene,
                      const perception::PointCloud& cloud, const perception::SensorNoise& noise);
// The same for these objects alone, which need not all be in the snapshot.
SceneMatch MatchScene(SnapshotPtr snapshot, std::vector<collision::WorldObjectPtr> known,
                      const perception::SceneInterpretation& scene,
                      const perception::PointCloud& cloud, const perception::SensorNoise& noise);

// The engines' geometry of detections, each prepared on first use and kept.
class DetectionGeometry {
 public:
  explicit DetectionGeometry(Detections detections)
      : detections_(detections), prepared_(static_cast<std::size_t>(detections.size())) {}

  std::shared_ptr<const collision::PreparedModel> Prepared(int detection);
  // Prepares the geometry that the match adds or replaces, on the threads of `work`; heavy, so no
  // lock may be held. Cancelled when stopped.
  absl::Status PrepareFor(const SceneMatch& match, IngestMode mode, const perception::Work& work);
  // The geometry prepared so far, one per detection; nullptr where none was.
  std::span<const std::shared_ptr<const collision::PreparedModel>> prepared() const {
    return prepared_;
  }

 private:
  Detections detections_;
  std::vector<std::shared_ptr<const collision::PreparedModel>> prepared_;
};

struct IngestPlan {
  std::vector<collision::Change> changes;
  // The name of the world's object behind each detection; empty if a user's geometry explains it.
  std::vector<std::string> names;
  std::vector<std::string> added, moved, replaced, removed, kept, occluded;
};

// Names the new objects and lists the changes. `next_name` returns the next free name of a stem.
// Internal if the associations do not cover the scene. In IngestMode::kAdd nothing is moved,
// removed or marked as occluded. Objects that a user owns or that are attached to a robot are never
// changed, whatever the associations say.
absl::StatusOr<IngestPlan> PlanIngest(
    const SceneMatch& match, const Detections& detections, IngestMode mode,
    DetectionGeometry& geometry,
    const std::function<std::string(const std::string& stem)>& next_name);

// The stem of new objects' names: "support", "object" or "residual".
std::string StemOf(collision::ObjectKind kind);

}  // namespace cwm::server
