// Fits the shapes of objects at rest to what several sensors see of them.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/live/shape_fusion.h"
#include "server/core/ingest.h"
#include "server/core/live/body_table.h"
#include "server/core/live/live_frame.h"
#include "server/core/world.h"

namespace cwm::server {

// Objects and the frames of the sensors that see them. A value: it may run anywhere.
struct FusionJob {
  std::shared_ptr<const BodyTable> bodies = {};
  std::vector<perception::BodyId> targets = {};
  std::vector<perception::MeanView> views = {};                  // without depths
  std::vector<std::vector<perception::StillFrame>> frames = {};  // one list for each view
  int max_threads = 1;
};

// Fits each target to all views and publishes those that are fitted better, one revision for each:
// they keep their names and are replaced. Objects that are parts of a target, as it was or as it is
// fitted (perception::PartsOf), are removed in its revision: their points are the target's. What
// was changed meanwhile is left as it is. The errors of World::Update; Cancelled when stopped.
absl::StatusOr<FrameChanges> FuseShapes(World& world, const FusionJob& job,
                                        const Interpreter& interpret, std::stop_token stop);

// Finds the objects that have come to rest before several sensors, and collects frames of them. Not
// thread safe; follows from the calls alone.
class ShapeFusion {
 public:
  // chosen: as SensorAgreement::kFrames.
  static constexpr std::size_t kFrames = 8;
  // chosen: what was put down is no longer touched.
  static constexpr auto kRestTime = std::chrono::seconds(1);
  // derived: kFrames at 30 Hz; they are collected in the last part of the rest.
  static constexpr auto kCollectTime = std::chrono::milliseconds(250);
  // chosen: what a sensor saw longer ago it may not see now.
  static constexpr auto kSeenTime = std::chrono::milliseconds(500);

  // Takes a frame of a trusted sensor, as it was compared with the bodies. `moving` are those that
  // do not rest.
  void Add(const perception::FrameEvidence& frame, const std::shared_ptr<const BodyTable>& bodies,
           const std::set<perception::BodyId>& moving);
  // The job for which all frames are there; one at a time.
  std::optional<FusionJob> TakeJob();
  void Finish(const std::vector<std::string>& replaced);
  bool is_running() const { return is_running_; }
  void Forget(const std::string& sensor);

 private:
  struct Object {
    collision::WorldObjectPtr object = {};               // as seen last
    perception::Stamp since = {};                        // it is like that
    std::map<std::string, perception::Stamp> seen = {};  // by sensor
    // The geometry that was fitted, or could not be fitted better, by these sensors.
    std::shared_ptr<const collision::PreparedModel> tried = {};
    std::set<std::string> tried_sensors = {};
    bool was_replaced = false;  // its next geometry is the fitted one
  };
  struct Collected {
    perception::MeanView view = {};
    std::vector<perception::StillFrame> frames = {};
    perception::Stamp last = {};
  };

  void Begin(perception::Stamp now, const BodyTable& bodies);
  bool IsDue(const Object& object, perception::Stamp now, std::set<std::string>& sensors) const;

  std::set<std::string> sensors_;
  std::map<std::string, Object> objects_;       // by name
  std::set<std::string> targets_;               // names
  std::map<std::string, Collected> collected_;  // of the sensors that see the targets
  std::shared_ptr<const BodyTable> bodies_;     // of the newest frame
  bool is_running_ = false;
};

}  // namespace cwm::server
