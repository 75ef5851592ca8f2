// The parts of one sensor's view that differ from what is known: movers, and what should be
// interpreted. A value: copies are independent.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "perception/live/frame_evidence.h"
#include "perception/live/tracker.h"

namespace cwm::perception {

class TrackedRegions {
 public:
  // True for a body that moves or settles: its region waits until it rests.
  using IsMoving = std::function<bool(BodyId)>;

  // The interpretation of the whole view, once, when the sensor has a reference.
  std::vector<RegionRequest> RequestView(const FrameEvidence& frame);
  // The regions that have come to rest and are not being interpreted.
  std::vector<RegionRequest> RequestRested(const FrameEvidence& frame, const IsMoving& is_moving);
  // The blocks of the request that have stayed the same since it was made.
  std::vector<std::int32_t> Finish(std::uint64_t request);

  // True once the whole view was interpreted.
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

  void KeepRest(const FrameEvidence& frame);
  std::uint64_t Ask(const FrameEvidence& frame, std::vector<std::int32_t> blocks, bool is_view);

  bool knows_view_ = false;
  bool asked_for_view_ = false;
  std::uint64_t last_number_ = 0;
  std::map<std::uint64_t, Pending> pending_;
  std::vector<Rested> rested_;  // hot blocks of the last frame, by block
  std::int32_t block_count_ = 0;
};

}  // namespace cwm::perception
