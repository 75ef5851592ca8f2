#include "perception/live/tracker.h"

#include <algorithm>
#include <chrono>
#include <deque>
#include <set>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/live/carrying.h"
#include "perception/live/mover_pieces.h"
#include "perception/live/tracked_body.h"
#include "perception/live/tracked_regions.h"
#include "perception/track/alignment.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {
namespace {

// chosen: a region with fewer points that nothing explains is left to the next frame, unless it has
// rested and was interpreted: then it is no noise.
constexpr std::size_t kMinMover_points = kThreeSamples;
// chosen: so many points of a region determine a share to five percent.
constexpr std::size_t kShareSample = 400;
// chosen: the pieces stay as they are while nearly all points lie in them and they are not much
// larger than needed, so that a mover that holds still makes no revision.
constexpr double kStillCovered = 0.995;
constexpr double kStillFilled = 0.7;
// chosen: the noise of single points that small pieces may leave out, or be too large by.
constexpr double kMaxLeftOut = 2;
constexpr double kMaxUnfilled_m3 = 1e-4;
// chosen: a carried body's shift that is worth a revision.
constexpr double kMinCarried_m = 0.0003;
// chosen: while its link holds still, what is seen of it must say that it is elsewhere by more.
constexpr double kMinHeld_m = 0.001;
constexpr double kLinkMoves_m = 0.0001;  // from frame to frame; encoders at rest say less
// chosen: frames of other sensors may have been compared with a world so many revisions ago.
constexpr std::size_t kKeptPoses = 16;

using PointLists = std::vector<std::vector<Eigen::Vector3f>>;

}  // namespace

struct TrackerState {
  // A body that a link may carry, and the poses that were published of it lately, the newest last.
  struct Carried {
    Carrying carrying = {};
    std::deque<Pose> published_W = {};
    Pose X_WB = Pose::Identity();  // in the last frame
  };
  struct Sensor {
    TrackedRegions regions = {};
    std::vector<MoverPiece> pieces = {};  // as published
  };
  std::map<BodyId, TrackedBody> bodies;
  std::map<BodyId, Carried> carried;
  std::map<std::string, Sensor> sensors;

  TrackedBody::Outcome Follow(const FrameEvidence& frame, const BodyEvidence& evidence,
                              const KnownBody& body, std::span<const PlacedSurface> supports,
                              std::span<const NeighbourBody> others, bool is_touched);
  bool IsCarried(BodyId id) const {
    const auto found = carried.find(id);
    return found != carried.end() && found->second.carrying.is_carried();
  }
};

namespace {

const KnownBody* Find(std::span<const KnownBody> bodies, BodyId id) {
  const auto found = std::ranges::find(bodies, id, &KnownBody::id);
  return found == bodies.end() ? nullptr : &*found;
}

// Forgets bodies that the world no longer has, or that are a user's or attached now.
void ForgetMissing(TrackerState& state, std::span<const KnownBody> bodies, StepResult& result) {
  std::set<BodyId> known;
  for (const KnownBody& body : bodies) {
    if (body.IsFollowed()) {
      known.insert(body.id);
    } else if (state.bodies.contains(body.id)) {
      result.facts_changed.push_back(body.id);
    }
  }
  const auto is_gone = [&](const auto& entry) { return !known.contains(entry.first); };
  std::erase_if(state.bodies, is_gone);
  std::erase_if(state.carried, is_gone);
}

// The change that publishes the pose of a carried body, if it differs from what was published.
std::optional<TrackChange> Published(BodyId id, TrackerState::Carried& carried, const Pose& X_WB,
                                     double least_m = kMinCarried_m) {
  std::deque<Pose>& published_W = carried.published_W;
  if (!published_W.empty()) {
    const Pose& last = published_W.back();
    const double turn =
        Eigen::AngleAxisd(Matrix3(last.linear().transpose() * X_WB.linear())).angle();
    const bool is_same = (last.translation() - X_WB.translation()).norm() < least_m &&
                         turn < least_m / kAlignmentReach_m;
    if (is_same) return std::nullopt;
  }
  published_W.push_back(X_WB);
  if (published_W.size() > kKeptPoses) published_W.pop_front();
  return TrackChange{.kind = TrackChange::Kind::kMove, .body = id, .X_WB = X_WB};
}

// The frame of a sensor that cannot judge carried bodies: they are where the links have them.
void MoveCarried(const FrameEvidence& frame, std::span<const KnownBody> bodies, TrackerState& state,
                 StepResult& result) {
  for (auto& [id, carried] : state.carried) {
    const auto X_WB = carried.carrying.PoseAt(frame.robots);
    if (!X_WB || Find(bodies, id) == nullptr) continue;
    if (auto change = Published(id, carried, *X_WB)) result.changes.push_back(*std::move(change));
  }
}

PlacedSurface Placed(const FrameEvidence& frame, std::shared_ptr<const BodySurface> surface,
                     Pose X_WB) {
  X_WB.translation() -= frame.X_WC.translation();
  return {std::move(surface), X_WB};
}

// The supports that were tracked before.
std::vector<PlacedSurface> Supports(const FrameEvidence& frame, std::span<const KnownBody> bodies,
                                    const std::map<BodyId, TrackedBody>& tracked) {
  std::vector<PlacedSurface> supports;
  for (const KnownBody& body : bodies) {
    if (body.kind != KnownBody::Kind::kSupport) continue;
    const auto found = tracked.find(body.id);
    if (found == tracked.end() || found->second.surface() == nullptr) continue;
    supports.push_back(Placed(frame, found->second.surface(), body.X_WB));
  }
  return supports;
}

// All bodies that were tracked before, for what robots may carry among them.
std::vector<NeighbourBody> Neighbours(const FrameEvidence& frame, std::span<const KnownBody> bodies,
                                      const std::map<BodyId, TrackedBody>& tracked) {
  std::vector<NeighbourBody> neighbours;
  for (const KnownBody& body : bodies) {
    const auto found = tracked.find(body.id);
    if (found == tracked.end() || found->second.surface() == nullptr) continue;
    neighbours.push_back({body.id, Placed(frame, found->second.surface(), body.X_WB)});
  }
  return neighbours;
}

// True if a hot region at the body has points that are too far from it to be its own.
bool IsTouched(const FrameEvidence& frame, const BodyEvidence& evidence, const KnownBody& body,
               const std::shared_ptr<const BodySurface>& surface) {
  if (!evidence.is_hot) return false;
  if (surface == nullptr) return true;
  const PlacedSurface placed = Placed(frame, surface, body.X_WB);
  for (const HotRegion& region : frame.regions) {
    if (!std::ranges::binary_search(region.bodies, body.id)) continue;
    const std::size_t step = 1 + region.points_L.size() / kShareSample;
    std::size_t all = 0;
    std::size_t own = 0;
    for (std::size_t i = 0; i < region.points_L.size(); i += step, ++all) {
      own += placed.Explains(region.points_L[i].cast<double>(), kAlignmentReach_m) ? 1 : 0;
    }
    if (static_cast<double>(own) < kMainShare * static_cast<double>(all)) return true;
  }
  return false;
}

// The points of regions that no moved body explains.
PointLists UnexplainedPoints(const FrameEvidence& frame, const TrackedRegions& regions,
                             const std::vector<PlacedSurface>& moved) {
  PointLists lists;
  for (const HotRegion& region : frame.regions) {
    std::vector<Eigen::Vector3f> left = region.points_L;
    for (const PlacedSurface& body : moved) {
      std::erase_if(left, [&](const Eigen::Vector3f& p) {
        const Vector3 p_L = p.cast<double>();
        return body.Explains(p_L, ExplainedWithin_m(frame.noise.AxialSigma_m(p_L.norm())));
      });
    }
    const bool is_enough =
        left.size() >= kMinMover_points || regions.IsUnmodelled(region, *frame.classes);
    if (is_enough && !left.empty()) lists.push_back(std::move(left));
  }
  return lists;
}

// The pieces to publish; empty if those that are published still do.
std::optional<std::vector<MoverPiece>> NewPieces(const PointLists& lists,
                                                 const std::vector<MoverPiece>& published,
                                                 const Vector3& origin_W) {
  if (lists.empty()) {
    if (published.empty()) return std::nullopt;
    return std::vector<MoverPiece>();
  }
  std::vector<MoverPiece> pieces = CoverByBoxes(lists, origin_W);
  if (published.empty()) return pieces;
  double points = 0;
  for (const std::vector<Eigen::Vector3f>& list : lists) points += static_cast<double>(list.size());
  const double left_out = (1 - CoveredShare(published, lists, origin_W)) * points;
  const double published_m3 = Volume_m3(published);
  const double unfilled_m3 = published_m3 - Volume_m3(pieces);
  if (left_out <= std::max(kMaxLeftOut, (1 - kStillCovered) * points) &&
      unfilled_m3 <= std::max(kMaxUnfilled_m3, (1 - kStillFilled) * published_m3)) {
    return std::nullopt;
  }
  return pieces;
}

TrackChange MoversChange(std::vector<MoverPiece> pieces) {
  return {.kind = TrackChange::Kind::kMovers, .pieces = std::move(pieces)};
}

}  // namespace

TrackedBody::Outcome TrackerState::Follow(const FrameEvidence& frame, const BodyEvidence& evidence,
                                          const KnownBody& body,
                                          std::span<const PlacedSurface> supports,
                                          std::span<const NeighbourBody> others, bool is_touched) {
  using Verdict = Carrying::Verdict;
  TrackedBody& tracked = bodies[body.id];
  if (!IsCarried(body.id)) {
    if (tracked.is_carried()) tracked.LetGo(frame.stamp, body.X_WB, false);
    TrackedBody::Outcome outcome = tracked.Update(frame, evidence, body, supports, is_touched);
    if (body.kind != KnownBody::Kind::kObject || frame.robots.empty()) return outcome;
    Carried& watched = carried[body.id];
    const Pose X_WB = outcome.X_WB.value_or(body.X_WB);
    const Carrying::Outcome begins =
        watched.carrying.Watch(frame, evidence, *tracked.surface(), others, X_WB, tracked.rests());
    if (begins.verdict != Verdict::kBegins) return outcome;
    watched.published_W.assign({body.X_WB});
    watched.X_WB = begins.X_WB;
    Published(body.id, watched, begins.X_WB);
    tracked.Carry(frame, &evidence, watched.carrying.carried_by(), true);
    return {.X_WB = begins.X_WB, .is_gone = false};
  }
  Carried& held = carried.at(body.id);
  if (!held.carrying.PoseAt(frame.robots)) {  // nobody knows where the link is
    tracked.Carry(frame, &evidence, held.carrying.carried_by(), false);
    return {};
  }
  const Carrying::Outcome judged =
      held.carrying.Follow(frame, evidence, *tracked.surface(), others, body.X_WB,
                           tracked.FitCarried(frame, evidence, body, supports));
  const bool link_moves =
      (body.X_WB.translation() - held.X_WB.translation()).norm() > kLinkMoves_m ||
      !body.X_WB.linear().isApprox(held.X_WB.linear(), kLinkMoves_m / kAlignmentReach_m);
  held.X_WB = judged.X_WB;
  const std::optional<TrackChange> change =
      Published(body.id, held, judged.X_WB, link_moves ? kMinCarried_m : kMinHeld_m);
  tracked.Carry(frame, &evidence, held.carrying.carried_by(), change.has_value());
  if (judged.verdict == Verdict::kEnds || judged.verdict == Verdict::kLost) {
    tracked.LetGo(frame.stamp, judged.X_WB, judged.verdict == Verdict::kLost);
  }
  return {.X_WB = change ? std::optional(change->X_WB) : std::nullopt, .is_gone = false};
}

Tracker::Tracker() : state_(std::make_unique<TrackerState>()) {}
Tracker::Tracker(const Tracker& other) : state_(std::make_unique<TrackerState>(*other.state_)) {}
Tracker& Tracker::operator=(const Tracker& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}
Tracker::~Tracker() = default;

void Tracker::PlaceCarried(std::span<const RobotLinks> robots, std::span<KnownBody> bodies) {
  for (KnownBody& body : bodies) {
    if (!state_->IsCarried(body.id)) continue;
    TrackerState::Carried& carried = state_->carried.at(body.id);
    const bool is_as_published = std::ranges::any_of(
        carried.published_W, [&](const Pose& X_WB) { return X_WB.isApprox(body.X_WB, 1e-9); });
    const auto X_WB = carried.carrying.PoseAt(robots);
    if (!is_as_published) {  // somebody else has moved it
      carried.carrying.Reset();
    } else if (X_WB) {
      body.X_WB = *X_WB;
    }
  }
}

StepResult Tracker::Step(const FrameEvidence& frame, std::span<const KnownBody> bodies) {
  StepResult result;
  TrackerState::Sensor& sensor = state_->sensors[frame.sensor];
  ForgetMissing(*state_, bodies, result);
  result.requests = sensor.regions.Request(frame, bodies, [this](BodyId id) {
    const auto found = state_->bodies.find(id);
    const bool rests = found == state_->bodies.end() || found->second.rests();
    return !rests || state_->IsCarried(id);
  });
  // Before the view of a sensor that stands was interpreted all in it is new.
  const bool knows_view = sensor.regions.knows_view() && frame.has_reference;
  if (!knows_view && !frame.is_moving) {
    if (!sensor.pieces.empty()) result.changes.push_back(MoversChange({}));
    sensor.pieces.clear();
    MoveCarried(frame, bodies, *state_, result);
    return result;
  }

  const std::vector<PlacedSurface> supports = Supports(frame, bodies, state_->bodies);
  const std::vector<NeighbourBody> others = frame.robots.empty()
                                                ? std::vector<NeighbourBody>()
                                                : Neighbours(frame, bodies, state_->bodies);
  std::vector<PlacedSurface> moved;
  std::set<BodyId> expected;
  for (const BodyEvidence& evidence : frame.bodies) {
    const KnownBody* const body = Find(bodies, evidence.id);
    if (body == nullptr || !body->IsFollowed()) continue;
    expected.insert(body->id);
    TrackedBody& tracked = state_->bodies[body->id];
    const TrackedFacts before = tracked.facts();
    const bool is_touched = IsTouched(frame, evidence, *body, tracked.surface());
    const TrackedBody::Outcome outcome =
        state_->Follow(frame, evidence, *body, supports, others, is_touched);
    if (outcome.X_WB) {
      result.changes.push_back(
          {.kind = TrackChange::Kind::kMove, .body = body->id, .X_WB = *outcome.X_WB});
    }
    if (outcome.X_WB || outcome.seen_at || !tracked.rests() || state_->IsCarried(body->id)) {
      const Pose X_WB = outcome.X_WB.value_or(outcome.seen_at.value_or(body->X_WB));
      moved.push_back(Placed(frame, tracked.surface(), X_WB));
    }
    if (outcome.is_gone && body->kind != KnownBody::Kind::kSupport) {
      result.changes.push_back({.kind = TrackChange::Kind::kRemove, .body = body->id});
    }
    if (tracked.facts() != before) result.facts_changed.push_back(body->id);
    const bool was_lost = before.visibility == Visibility::kLost;
    if (was_lost && tracked.facts().visibility != Visibility::kLost && !outcome.is_gone) {
      result.found_again.push_back(body->id);
    }
  }
  for (auto& [id, tracked] : state_->bodies) {
    if (expected.contains(id)) continue;
    const TrackedFacts before = tracked.facts();
    if (state_->IsCarried(id)) {
      TrackerState::Carried& carried = state_->carried.at(id);
      const auto X_WB = carried.carrying.PoseAt(frame.robots);
      auto change = X_WB ? Published(id, carried, *X_WB) : std::nullopt;
      tracked.Carry(frame, nullptr, carried.carrying.carried_by(), change.has_value());
      if (change) result.changes.push_back(*std::move(change));
    } else if (tracked.OutOfView(frame).is_gone) {
      result.changes.push_back({.kind = TrackChange::Kind::kRemove, .body = id});
    }
    if (tracked.facts() != before) result.facts_changed.push_back(id);
  }
  auto pieces = NewPieces(UnexplainedPoints(frame, sensor.regions, moved), sensor.pieces,
                          frame.X_WC.translation());
  if (pieces) {
    sensor.pieces = *pieces;
    result.changes.push_back(MoversChange(*std::move(pieces)));
  }
  return result;
}

std::vector<std::int32_t> Tracker::SameSince(const std::string& sensor,
                                             std::uint64_t request) const {
  const auto found = state_->sensors.find(sensor);
  if (found == state_->sensors.end()) return {};
  return found->second.regions.SameSince(request);
}

std::vector<std::int32_t> Tracker::Finish(const std::string& sensor, std::uint64_t request,
                                          bool succeeded,
                                          std::span<const std::int32_t> unmodelled) {
  const auto found = state_->sensors.find(sensor);
  if (found == state_->sensors.end()) return {};
  return found->second.regions.Finish(request, succeeded, unmodelled);
}

std::vector<TrackChange> Tracker::ForgetSensor(const std::string& sensor) {
  std::vector<TrackChange> changes;
  const auto found = state_->sensors.find(sensor);
  if (found == state_->sensors.end()) return changes;
  if (!found->second.pieces.empty()) changes.push_back(MoversChange({}));
  state_->sensors.erase(found);
  for (auto& [id, tracked] : state_->bodies) tracked.ForgetSensor(sensor);
  return changes;
}

TrackedFacts Tracker::FactsOf(BodyId body) const {
  const auto found = state_->bodies.find(body);
  return found == state_->bodies.end() ? TrackedFacts() : found->second.facts();
}

}  // namespace cwm::perception
