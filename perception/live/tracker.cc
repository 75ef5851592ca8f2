#include "perception/live/tracker.h"

#include <algorithm>
#include <chrono>
#include <set>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/live/mover_pieces.h"
#include "perception/live/tracked_body.h"
#include "perception/live/tracked_regions.h"
#include "perception/track/alignment.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {
namespace {

// chosen: a region with fewer points that nothing explains is left to the next frame.
constexpr std::size_t kLeastMover_points = kThreeSamples;
// chosen: so many points of a region determine a share to five percent.
constexpr std::size_t kShareSample = 400;
// chosen: the pieces stay as they are while nearly all points lie in them and they are not much
// larger than needed, so that a mover that holds still makes no revision.
constexpr double kStillCovered = 0.995;
constexpr double kStillFilled = 0.7;

using PointLists = std::vector<std::vector<Eigen::Vector3f>>;

}  // namespace

struct TrackerState {
  struct Sensor {
    TrackedRegions regions = {};
    std::vector<MoverPiece> pieces = {};  // as published
  };
  std::map<BodyId, TrackedBody> bodies;
  std::map<std::string, Sensor> sensors;
};

namespace {

const KnownBody* Find(std::span<const KnownBody> bodies, BodyId id) {
  const auto found = std::ranges::find(bodies, id, &KnownBody::id);
  return found == bodies.end() ? nullptr : &*found;
}

// Forgets bodies that the world no longer has.
void ForgetMissing(std::map<BodyId, TrackedBody>& tracked, std::span<const KnownBody> bodies) {
  std::set<BodyId> known;
  for (const KnownBody& body : bodies) known.insert(body.id);
  std::erase_if(tracked, [&](const auto& entry) { return !known.contains(entry.first); });
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
PointLists UnexplainedPoints(const FrameEvidence& frame, const std::vector<PlacedSurface>& moved) {
  PointLists lists;
  for (const HotRegion& region : frame.regions) {
    std::vector<Eigen::Vector3f> left = region.points_L;
    for (const PlacedSurface& body : moved) {
      std::erase_if(left, [&](const Eigen::Vector3f& p) {
        const Vector3 p_L = p.cast<double>();
        return body.Explains(p_L, ExplainedWithin_m(frame.noise.AxialSigma_m(p_L.norm())));
      });
    }
    if (left.size() >= kLeastMover_points) lists.push_back(std::move(left));
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
  if (!published.empty() && CoveredShare(published, lists, origin_W) >= kStillCovered &&
      Volume_m3(pieces) >= kStillFilled * Volume_m3(published)) {
    return std::nullopt;
  }
  return pieces;
}

TrackChange MoversChange(std::vector<MoverPiece> pieces) {
  return {.kind = TrackChange::Kind::kMovers, .pieces = std::move(pieces)};
}

}  // namespace

Tracker::Tracker() : state_(std::make_unique<TrackerState>()) {}
Tracker::Tracker(const Tracker& other) : state_(std::make_unique<TrackerState>(*other.state_)) {}
Tracker& Tracker::operator=(const Tracker& other) {
  if (this != &other) *state_ = *other.state_;
  return *this;
}
Tracker::~Tracker() = default;

StepResult Tracker::Step(const FrameEvidence& frame, std::span<const KnownBody> bodies) {
  StepResult result;
  TrackerState::Sensor& sensor = state_->sensors[frame.sensor];
  ForgetMissing(state_->bodies, bodies);
  result.requests = sensor.regions.Request(frame, [this](BodyId id) {
    const auto found = state_->bodies.find(id);
    return found != state_->bodies.end() && !found->second.rests();
  });
  // Before the view was interpreted all in it is new, and a moving sensor cannot tell what moves
  // from the errors of its pose.
  if (!sensor.regions.knows_view() || !frame.has_reference) {
    if (!sensor.pieces.empty()) result.changes.push_back(MoversChange({}));
    sensor.pieces.clear();
    return result;
  }

  const std::vector<PlacedSurface> supports = Supports(frame, bodies, state_->bodies);
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
        tracked.Update(frame, evidence, *body, supports, is_touched);
    if (outcome.X_WB) {
      result.changes.push_back(
          {.kind = TrackChange::Kind::kMove, .body = body->id, .X_WB = *outcome.X_WB});
    }
    if (outcome.X_WB || !tracked.rests()) {
      moved.push_back(Placed(frame, tracked.surface(), outcome.X_WB.value_or(body->X_WB)));
    }
    if (outcome.is_gone && body->kind != KnownBody::Kind::kSupport) {
      result.changes.push_back({.kind = TrackChange::Kind::kRemove, .body = body->id});
    }
    if (tracked.facts() != before) result.facts_changed.push_back(body->id);
  }
  for (auto& [id, tracked] : state_->bodies) {
    if (expected.contains(id)) continue;
    const TrackedFacts before = tracked.facts();
    if (tracked.OutOfView(frame).is_gone) {
      result.changes.push_back({.kind = TrackChange::Kind::kRemove, .body = id});
    }
    if (tracked.facts() != before) result.facts_changed.push_back(id);
  }
  auto pieces = NewPieces(UnexplainedPoints(frame, moved), sensor.pieces, frame.X_WC.translation());
  if (pieces) {
    sensor.pieces = *pieces;
    result.changes.push_back(MoversChange(*std::move(pieces)));
  }
  return result;
}

std::vector<std::int32_t> Tracker::Finish(const std::string& sensor, std::uint64_t request,
                                          bool succeeded) {
  const auto found = state_->sensors.find(sensor);
  if (found == state_->sensors.end()) return {};
  return found->second.regions.Finish(request, succeeded);
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
