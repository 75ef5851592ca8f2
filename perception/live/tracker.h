// Follows the objects of a world from frame to frame: which rest, move, are hidden, gone, new.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collision/geometry/aabb.h"
#include "perception/live/frame_evidence.h"

namespace cwm::perception {

enum class Motion : std::uint8_t { kAtRest, kMoving, kSettling };
enum class Visibility : std::uint8_t { kVisible, kOccluded, kStale, kLost };

// The facts about one followed body that make no revision.
struct TrackedFacts {
  Motion motion = Motion::kAtRest;
  Visibility visibility = Visibility::kStale;
  bool identity_certain = true;
  std::string carried_by = {};  // "robot/link"

  friend bool operator==(const TrackedFacts&, const TrackedFacts&) = default;
};

// A connected piece of something that moves and is not modelled: boxes around its points, in the
// world's axes.
struct MoverPiece {
  std::vector<Aabb> boxes_W = {};
};
inline constexpr int kMaxMoverBoxes = 64;  // of all pieces that a sensor sees

// One change of the world that a frame calls for.
struct TrackChange {
  enum class Kind {
    kMove,    // body, X_WB
    kRemove,  // body
    kMovers   // pieces: all that this sensor sees now; empty: none any more
  };
  Kind kind = Kind::kMove;
  BodyId body = kNoBody;
  Pose X_WB = Pose::Identity();
  std::vector<MoverPiece> pieces = {};
};

// A part of the view that should be interpreted beside the frames.
struct RegionRequest {
  std::uint64_t number = 0;               // given back with the interpretation
  std::vector<std::int32_t> blocks = {};  // of the view, ascending
  std::vector<BodyId> bodies = {};        // known bodies that may have changed there
  bool is_whole_view = false;             // nothing of the view was interpreted before
  // A moving sensor sees it for the first time: it may add things, and parts to what was seen in
  // part. A whole view if much of it is new.
  bool is_new_surface = false;
  // It has rested for so long that nobody holds it: it need not look as if it could (MayRest).
  bool has_rested_long = false;
};

struct TrackerState;  // a value: copies are independent

struct StepResult {
  std::vector<TrackChange> changes = {};
  std::vector<RegionRequest> requests = {};
  // Bodies whose facts changed.
  std::vector<BodyId> facts_changed = {};
  // Bodies that were lost and are seen again.
  std::vector<BodyId> found_again = {};
};

// A value: copies are independent of each other. Deterministic: the same calls give the same
// results. No clock, no threads.
class Tracker {
 public:
  Tracker();
  Tracker(const Tracker& other);
  Tracker& operator=(const Tracker& other);
  ~Tracker();

  // Moves the bodies that links of robots carry, though nobody attached them, to their places at a
  // stamp: those that a frame of that stamp is to be compared with.
  void PlaceCarried(std::span<const RobotLinks> robots, std::span<KnownBody> bodies);

  // Takes the evidence of one frame. `bodies` are those that the frame was compared with.
  StepResult Step(const FrameEvidence& frame, std::span<const KnownBody> bodies);

  // The blocks of an open request of a sensor at rest that have stayed the same since it was made.
  // A thing that an interpretation finds elsewhere may have left.
  std::vector<std::int32_t> SameSince(const std::string& sensor, std::uint64_t request) const;

  // Tells that the interpretation of a request is part of the world now, or, if not `succeeded`,
  // could not be made: then it is asked for again after some seconds. Returns the blocks of the
  // request that have stayed the same since: what they show is known, and the sensor's view should
  // accept it (SensorView::Accept), but for those that are `unmodelled`: no body was made of what
  // they show (UnmodelledBlocks). That is a mover until it changes, and is not asked for again.
  std::vector<std::int32_t> Finish(const std::string& sensor, std::uint64_t request,
                                   bool succeeded = true,
                                   std::span<const std::int32_t> unmodelled = {});

  // Forgets a sensor that no longer streams: its movers are gone (a change), its evidence is void.
  std::vector<TrackChange> ForgetSensor(const std::string& sensor);

  TrackedFacts FactsOf(BodyId body) const;

 private:
  std::unique_ptr<TrackerState> state_;
};

}  // namespace cwm::perception
