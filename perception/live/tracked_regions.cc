#include "perception/live/tracked_regions.h"

#include <algorithm>
#include <chrono>
#include <numeric>
#include <utility>

#include "perception/cloud/tolerances.h"

namespace cwm::perception {
namespace {

// chosen: a hand that holds still for so long and in so many frames is interpreted as well.
constexpr double kMinRest_s = 0.3;
constexpr int kMinRestFrames = 5;
// chosen: what could not be interpreted, e.g. for a full disk, is not tried with every frame.
constexpr std::chrono::seconds kRetryTime{3};
// chosen: a thing that a gripper holds or has just put down shows a part of itself, and so does what
// reaches into the view, such as an arm; beside what has just moved may be what moved it. They are
// interpreted when the gripper or the arm is away, or does not go for so long. So is what was
// interpreted before and made no body.
constexpr double kMinRestOfCut_s = 3;
// chosen: nobody holds a thing, or a hand, still for so long.
constexpr double kMinRestOfHeld_s = 10;
// derived: the region of a thing that moved is asked for within this time.
constexpr double kMovedTime_s = 2 * kMinRestOfCut_s;
// chosen: fewer pixels of robots beside a region, as a share of its own, cut nothing off.
constexpr double kCutShare = 0.1;
// derived: the points of a region reach one block beyond its own.
constexpr int kSharedBlocks = 2;
// chosen: surfaces that a moving sensor sees for the first time and that fill fewer blocks may be
// the fringe of known ones, by the error of its pose. A cup at 1.5 m has thirty blocks.
constexpr int kMinNewSurface_blocks = 6;
// derived: what has come or gone and still moves, at 3 cm/s or more, leaves a cell of the world in
// this time.
constexpr double kMinRestInWorld_s = 1;
// chosen: what reaches the border of a moving sensor's view is seen whole a little later, or it is
// larger than the view.
constexpr double kMinRestAtBorder_s = 2;
// chosen: if so much of a moving sensor's view is new, all of it is interpreted, so that large
// surfaces are found whole. A camera that turns has a few such views a second at most.
constexpr double kLargelyNew = 0.2;

bool Intersects(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
  auto i = a.begin();
  auto j = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i == *j) return true;
    *i < *j ? static_cast<void>(++i) : static_cast<void>(++j);
  }
  return false;
}

bool IsOfRobot(PixelClass pixel) {
  return pixel == PixelClass::kRobot || pixel == PixelClass::kCarried ||
         pixel == PixelClass::kMixed || pixel == PixelClass::kHidden;
}

// The blocks and those around them within the distance, ascending.
std::vector<std::int32_t> Around(const std::vector<std::int32_t>& blocks, int distance,
                                 const FrameClasses& classes) {
  std::vector<std::int32_t> around;
  for (const std::int32_t block : blocks) {
    for (int row = -distance; row <= distance; ++row) {
      for (int column = -distance; column <= distance; ++column) {
        const int c = block % classes.block_columns + column;
        const int r = block / classes.block_columns + row;
        if (c < 0 || r < 0 || c >= classes.block_columns || r >= classes.block_rows) continue;
        around.push_back(r * classes.block_columns + c);
      }
    }
  }
  std::ranges::sort(around);
  around.erase(std::unique(around.begin(), around.end()), around.end());
  return around;
}

// True if a robot hides a part of what the region shows: its pixels are in or beside the region's
// blocks.
bool IsCut(const FrameEvidence& frame, const HotRegion& region) {
  const FrameClasses& classes = *frame.classes;
  int robot = 0;
  for (const std::int32_t block : Around(region.blocks, 1, classes)) {
    const PixelRectangle pixels = classes.PixelsOf(block);
    for (int v = pixels.v_begin; v < pixels.v_end; ++v) {
      for (int u = pixels.u_begin; u < pixels.u_end; ++u) {
        robot += IsOfRobot(classes.pixels[static_cast<std::size_t>(v) * classes.width + u]) ? 1 : 0;
      }
    }
  }
  return robot > kCutShare * (region.nearer + region.farther);
}

// The bodies at a region that may be others than they were. What has come is no part of a thing that
// still looks as before, however near it is. What something else hid may be, and a thing that moved
// may show another side.
std::vector<BodyId> ChangedBodies(const FrameEvidence& frame, const HotRegion& region,
                                  std::span<const KnownBody> bodies,
                                  const std::map<BodyId, Stamp>& moved) {
  std::vector<BodyId> changed = region.bodies;
  if (region.entered < kMainShare * (region.nearer + region.farther)) return changed;
  for (const KnownBody& body : bodies) {
    if (body.kind == KnownBody::Kind::kSupport || moved.contains(body.id)) continue;
    const auto evidence = std::ranges::lower_bound(frame.bodies, body.id, {}, &BodyEvidence::id);
    if (evidence == frame.bodies.end() || evidence->id != body.id) continue;
    const bool is_shown = evidence->consistent >= kMinSignificantShare * evidence->expected;
    if (is_shown && !evidence->IsSeenThrough()) std::erase(changed, body.id);
  }
  return changed;
}

Stamp Before(Stamp stamp, double seconds) {
  return stamp -
         std::chrono::duration_cast<Stamp::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

std::uint64_t TrackedRegions::Ask(const FrameEvidence& frame, std::vector<std::int32_t> blocks,
                                  bool is_view) {
  ++last_number_;
  pending_[last_number_] = {.stamp = frame.stamp, .blocks = std::move(blocks), .is_view = is_view};
  return last_number_;
}

std::vector<RegionRequest> TrackedRegions::Request(const FrameEvidence& frame,
                                                   std::span<const KnownBody> bodies,
                                                   const IsMoving& is_moving) {
  KeepRest(frame);
  KeepMoved(frame, is_moving);
  stamp_ = frame.stamp;
  const bool has_moved = has_pose_ && frame.X_WC.matrix() != X_WC_.matrix();
  // The second frame tells whether a sensor moves that may.
  const bool is_unclear = !has_pose_ && frame.may_move;
  has_pose_ = true;
  X_WC_ = frame.X_WC;
  if (has_moved) {
    // The sensor will have another view when it comes to stand.
    knows_view_ = false;
    asked_for_view_ = false;
    for (auto& [number, pending] : pending_) pending.is_view = false;
    return frame.stamp < not_before_ ? std::vector<RegionRequest>() : RequestNew(frame, is_moving);
  }
  if (is_unclear || frame.stamp < not_before_) return {};
  if (!asked_for_view_) return RequestView(frame);
  return knows_view_ ? RequestRested(frame, bodies, is_moving) : std::vector<RegionRequest>();
}

std::vector<RegionRequest> TrackedRegions::RequestView(const FrameEvidence& frame) {
  if (interprets()) return {};  // of the time before the sensor stood still
  asked_for_view_ = true;
  RegionRequest request{.is_whole_view = true};
  request.blocks.resize(frame.classes->hot_blocks.size());
  std::iota(request.blocks.begin(), request.blocks.end(), 0);
  for (const BodyEvidence& body : frame.bodies) request.bodies.push_back(body.id);
  request.number = Ask(frame, request.blocks, true);
  return {std::move(request)};
}

std::vector<RegionRequest> TrackedRegions::RequestNew(const FrameEvidence& frame,
                                                      const IsMoving& is_moving) {
  if (interprets()) return {};
  RegionRequest request{.is_new_surface = true};
  int new_blocks = 0;
  for (const HotRegion& region : frame.regions) {
    if (region.full_blocks < kMinNewSurface_blocks || region.nearer < region.farther) continue;
    if (std::ranges::any_of(region.bodies, is_moving)) continue;
    if (region.is_cut) {
      if (region.half_rest_s >= kMinRest_s) new_blocks += region.full_blocks;
      request.is_whole_view |= region.half_rest_s >= kMinRestAtBorder_s;
      continue;
    }
    const double least_rest_s = IsCut(frame, region) ? kMinRestOfCut_s
                                : region.points_L.empty() && region.farther == 0
                                    ? kMinRest_s
                                    : kMinRestInWorld_s;
    if (region.rest_s < least_rest_s || region.rest_frames < kMinRestFrames) continue;
    new_blocks += region.full_blocks;
    request.blocks.insert(request.blocks.end(), region.blocks.begin(), region.blocks.end());
  }
  const auto all_blocks = static_cast<int>(frame.classes->hot_blocks.size());
  request.is_whole_view |= new_blocks >= kLargelyNew * all_blocks;
  if (request.is_whole_view) {
    request.blocks.resize(frame.classes->hot_blocks.size());
    std::iota(request.blocks.begin(), request.blocks.end(), 0);
  }
  if (request.blocks.empty()) return {};
  std::ranges::sort(request.blocks);
  request.number = Ask(frame, request.blocks, false);
  return {std::move(request)};
}

std::vector<RegionRequest> TrackedRegions::RequestRested(const FrameEvidence& frame,
                                                         std::span<const KnownBody> bodies,
                                                         const IsMoving& is_moving) {
  std::vector<RegionRequest> requests;
  for (const HotRegion& region : frame.regions) {
    const bool has_moved =
        std::ranges::any_of(region.bodies, [this](BodyId body) { return moved_.contains(body); });
    const bool is_unmodelled = IsUnmodelled(region, *frame.classes);
    const bool waits = region.is_cut || has_moved || is_unmodelled || IsCut(frame, region);
    const double least_rest_s = waits ? kMinRestOfCut_s : kMinRest_s;
    if (region.rest_s < least_rest_s || region.rest_frames < kMinRestFrames) continue;
    if (std::ranges::any_of(region.bodies, is_moving)) continue;
    const bool has_rested_long = region.rest_s >= kMinRestOfHeld_s;
    const Stamp changed =
        Before(frame.stamp, region.rest_s - (has_rested_long ? kMinRestOfHeld_s : 0));
    const auto was_seen_so = [&](const Unmodelled& each) {
      return each.interpreted >= changed || !std::ranges::binary_search(region.blocks, each.block);
    };
    if (is_unmodelled && std::ranges::all_of(unmodelled_, was_seen_so)) continue;
    // Things reach over the border of their blocks, so regions that are near each other may show
    // parts of one thing: the second waits for what the first one is found to be.
    const auto beside = Around(region.blocks, kSharedBlocks, *frame.classes);
    if (std::ranges::any_of(pending_, [&](const auto& pending) {
          return Intersects(pending.second.blocks, beside);
        })) {
      continue;
    }
    RegionRequest request{.blocks = region.blocks,
                          .bodies = ChangedBodies(frame, region, bodies, moved_),
                          .has_rested_long = has_rested_long};
    request.number = Ask(frame, region.blocks, false);
    requests.push_back(std::move(request));
  }
  return requests;
}

void TrackedRegions::KeepMoved(const FrameEvidence& frame, const IsMoving& is_moving) {
  for (const BodyEvidence& body : frame.bodies) {
    if (is_moving(body.id)) moved_[body.id] = frame.stamp;
  }
  std::erase_if(moved_, [since = Before(frame.stamp, kMovedTime_s)](const auto& moved) {
    return moved.second < since;
  });
}

void TrackedRegions::KeepRest(const FrameEvidence& frame) {
  rested_.clear();
  for (const HotRegion& region : frame.regions) {
    for (const std::int32_t block : region.blocks) {
      rested_.push_back({block, Before(frame.stamp, region.rest_s)});
    }
  }
  std::ranges::sort(rested_, {}, &Rested::block);
  // Blocks at outlines flicker.
  const Stamp kept_since = Before(frame.stamp, kMinRest_s);
  for (Unmodelled& each : unmodelled_) {
    if (std::ranges::binary_search(rested_, each.block, {}, &Rested::block)) each.hot = frame.stamp;
  }
  std::erase_if(unmodelled_, [&](const Unmodelled& each) { return each.hot < kept_since; });
}

bool TrackedRegions::IsUnmodelled(const HotRegion& region, const FrameClasses& classes) const {
  if (unmodelled_.empty()) return false;
  std::vector<std::int32_t> known;
  for (const Unmodelled& each : unmodelled_) known.push_back(each.block);
  return std::ranges::includes(Around(known, 1, classes), region.blocks);
}

std::vector<std::int32_t> TrackedRegions::Finish(std::uint64_t request, bool succeeded,
                                                 std::span<const std::int32_t> unmodelled) {
  const auto found = pending_.find(request);
  if (found == pending_.end()) return {};
  const bool is_view = found->second.is_view;
  std::vector<std::int32_t> same;
  if (succeeded) {
    same = SameSince(request);
    if (is_view) knows_view_ = true;
    for (const std::int32_t block : unmodelled) {
      std::erase_if(unmodelled_, [block](const Unmodelled& each) { return each.block == block; });
      unmodelled_.push_back({block, found->second.stamp, stamp_});
    }
    std::ranges::sort(unmodelled_, {}, &Unmodelled::block);
  } else {
    if (is_view) asked_for_view_ = false;
    not_before_ = stamp_ + kRetryTime;
  }
  pending_.erase(found);
  return same;
}

std::vector<std::int32_t> TrackedRegions::SameSince(std::uint64_t request) const {
  const auto found = pending_.find(request);
  if (found == pending_.end()) return {};
  const Pending& pending = found->second;
  // A region was at rest since before it was asked for, or it has changed since.
  std::vector<std::int32_t> same;
  for (const Rested& rested : rested_) {
    if (rested.since <= pending.stamp && std::ranges::binary_search(pending.blocks, rested.block)) {
      same.push_back(rested.block);
    }
  }
  return same;
}

}  // namespace cwm::perception
