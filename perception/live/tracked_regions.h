// The parts of one sensor's view that differ from what is known: movers, and what should be
// interpreted. A value: copies are independent.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "perception/live/frame_evidence.h"
#include "perception/live/tracker.h"

namespace cwm::perception {

class TrackedRegions {
 public:
  // True for a body that moves or settles: its region waits until it rests.
  using IsMoving = std::function<bool(BodyId)>;

  // The parts of the view to interpret beside the frames: the whole view of a sensor that has begun
  // or come to stand; regions that have come to rest; and, while the sensor moves, surfaces that it
  // sees for the first time, one request after the other.
  std::vector<RegionRequest> Request(const FrameEvidence& frame, std::span<const KnownBody> bodies,
                                     const IsMoving& is_moving);
  // The blocks of an open request that have stayed the same since it was made.
  std::vector<std::int32_t> SameSince(std::uint64_t request) const;
  // Ends a request; returns SameSince. Without success nothing is asked for some seconds, and then
  // again. The interpretation made no body of what `unmodelled` blocks of the request show: they
  // stay open, and are not asked for again while they rest.
  std::vector<std::int32_t> Finish(std::uint64_t request, bool succeeded,
                                   std::span<const std::int32_t> unmodelled);

  // True for a region of the last frame that has nothing new in it since no body was made of what it
  // shows.
  bool IsUnmodelled(const HotRegion& region, const FrameClasses& classes) const;

  // True once the whole view was interpreted, for a sensor that stands still.
  bool knows_view() const { return knows_view_; }
  bool interprets() const { return !pending_.empty(); }

 private:
  struct Pending {
    Stamp stamp = {};  // of the frame that asked
    std::vector<std::int32_t> blocks = {};
    bool is_view = false;
  };
  // A block in the last frame.
  struct Rested {
    std::int32_t block = 0;
    Stamp since = {};
  };
  // A hot block of which no body was made.
  struct Unmodelled {
    std::int32_t block = 0;
    Stamp interpreted = {};  // the frame that was
    Stamp hot = {};          // the last frame in which it was hot
  };

  std::vector<RegionRequest> RequestView(const FrameEvidence& frame);
  std::vector<RegionRequest> RequestRested(const FrameEvidence& frame,
                                           std::span<const KnownBody> bodies,
                                           const IsMoving& is_moving);
  std::vector<RegionRequest> RequestNew(const FrameEvidence& frame, const IsMoving& is_moving);
  void KeepRest(const FrameEvidence& frame);
  void KeepMoved(const FrameEvidence& frame, const IsMoving& is_moving);
  std::uint64_t Ask(const FrameEvidence& frame, std::vector<std::int32_t> blocks, bool is_view);

  bool knows_view_ = false;
  bool asked_for_view_ = false;
  Stamp stamp_ = {};       // of the last frame
  Stamp not_before_ = {};  // of the next request, after a failure
  bool has_pose_ = false;
  Pose X_WC_ = Pose::Identity();  // of the last frame
  std::uint64_t last_number_ = 0;
  std::map<std::uint64_t, Pending> pending_;
  std::vector<Rested> rested_;  // hot blocks of the last frame, by block
  std::vector<Unmodelled> unmodelled_;
  std::map<BodyId, Stamp> moved_;  // when a body of the view moved last, for some seconds
};

}  // namespace cwm::perception
