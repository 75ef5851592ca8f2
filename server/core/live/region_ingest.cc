#include "server/core/live/region_ingest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/live/new_surfaces.h"
#include "perception/live/region_cloud.h"
#include "perception/live/static_balance.h"
#include "server/core/ingest_plan.h"
#include "server/core/stale_changes.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::ObjectKind;
using collision::WorldObject;
using collision::WorldObjectPtr;
using perception::Association;
using Outcome = Association::Outcome;

// The objects that the associations of a region are about.
struct Scope {
  std::vector<WorldObjectPtr> known;      // of the world, then those that are gone
  std::size_t present = 0;                // the first of `known` are in the world
  std::set<std::string> may_change;       // names
  std::set<std::string> is_seen_through;  // those of them through a part of which rays pass
};

Scope ScopeOf(const RegionJob& job, const collision::WorldSnapshot& snapshot) {
  Scope scope;
  for (const perception::BodyId id : job.request.bodies) {
    const WorldObjectPtr object = job.bodies->Find(id);
    if (object != nullptr && object->kind != ObjectKind::kSupport) {
      scope.may_change.insert(object->name);
      const auto evidence =
          std::ranges::lower_bound(job.frame.bodies, id, {}, &perception::BodyEvidence::id);
      const bool is_seen = evidence != job.frame.bodies.end() && evidence->id == id;
      if (is_seen && evidence->IsSeenThrough()) scope.is_seen_through.insert(object->name);
    }
  }
  for (const WorldObjectPtr& object : snapshot.objects()) {
    if (object->kind == ObjectKind::kUnseen || object->kind == ObjectKind::kMover) continue;
    const bool matters = object->kind == ObjectKind::kSupport ||
                         object->owner == collision::Owner::kUser ||
                         object->attachment != nullptr || scope.may_change.contains(object->name);
    if (matters) scope.known.push_back(object);
  }
  scope.present = scope.known.size();
  for (const WorldObjectPtr& object : job.gone) {
    if (snapshot.Find(object->name) == nullptr) scope.known.push_back(object);
  }
  return scope;
}

// chosen: what has come and shows in fewer pixels is noise, or so small that the sensor could not
// tell that it is gone: its model shows in some of them alone, and two dozen must be seen through.
constexpr double kMinChanged_px = 48;

// The news of a region against what was known.
struct RegionNews {
  // By detected object, the share of its points that differ from what was known; 0 if they are few,
  // or if a significant share of them has changed again since.
  std::vector<double> changed_shares = {};
  // Blocks of the objects that have changed since, ascending.
  std::vector<std::int32_t> outdated_blocks = {};
};

RegionNews NewsOf(const RegionJob& job, const perception::SceneInterpretation& scene,
                  const std::vector<std::int32_t>& same_blocks) {
  // The first object has the second ten of labels.
  constexpr std::uint32_t kLabelsOfObject = 10, kFirstObject = 2;
  const perception::FrameClasses& classes = *job.frame.classes;
  std::vector<bool> has_changed_since(classes.hot_blocks.size());
  for (const std::int32_t block : job.request.blocks) {
    has_changed_since[static_cast<std::size_t>(block)] =
        !std::ranges::binary_search(same_blocks, block);
  }
  struct Points {
    double all = 0, changed = 0, since = 0;
    std::set<std::int32_t> blocks = {};
  };
  std::vector<Points> points(scene.objects.size());
  for (std::size_t i = 0; i < scene.labels.size(); ++i) {
    const std::size_t object = std::size_t{scene.labels[i] / kLabelsOfObject} - kFirstObject;
    if (object >= points.size()) continue;  // of a support, or none
    Points& of = points[object];
    const std::int32_t block = classes.BlockOf(i);
    ++of.all;
    of.blocks.insert(of.blocks.end(), block);
    if (classes.pixels[i] == perception::PixelClass::kConsistent) continue;
    ++of.changed;
    if (has_changed_since[static_cast<std::size_t>(block)]) ++of.since;
  }
  RegionNews news;
  std::set<std::int32_t> outdated;
  for (const Points& of : points) {
    const bool is_outdated = of.since > perception::kMinSignificantShare * of.all;
    if (is_outdated) outdated.insert(of.blocks.begin(), of.blocks.end());
    const bool is_told = of.changed >= kMinChanged_px && !is_outdated;
    news.changed_shares.push_back(is_told ? of.changed / of.all : 0);
  }
  news.outdated_blocks.assign(outdated.begin(), outdated.end());
  return news;
}

// By detected object: false if something must hold it.
std::vector<bool> MayRest(const RegionJob& job, const perception::SceneInterpretation& scene) {
  std::vector<bool> may_rest(scene.objects.size(), true);
  for (std::size_t i = 0; i < may_rest.size() && !job.request.has_rested_long; ++i) {
    const perception::DetectedObject& object = scene.objects[i];
    const auto support = static_cast<std::size_t>(object.supported_by);
    may_rest[i] = object.supported_by >= 0 &&
                  perception::MayRest(object.points_L, scene.supports[support].X_WO, job.frame);
  }
  return may_rest;
}

// A thing that something holds is a hand or in one: it is not new, and no known thing became it.
void KeepHeld(SceneMatch& match, const Scope& scope, const std::vector<bool>& may_rest) {
  for (Association& association : match.associations) {
    const bool is_held =
        association.object >= 0 && !may_rest[static_cast<std::size_t>(association.object)];
    if (!is_held || association.outcome == Outcome::kExplained) continue;
    const bool is_present =
        association.known >= 0 && static_cast<std::size_t>(association.known) < scope.present;
    association.outcome = is_present ? Outcome::kKeep : Outcome::kExplained;
    if (!is_present) association.known = -1;
  }
}

// Restricts what the associations say to what the region shows. A detection that did not change is
// no news: noise, and a view of a part, let the interpreter see it differently now.
void Restrict(SceneMatch& match, const Scope& scope, const std::vector<double>& changed_shares) {
  std::erase_if(match.associations, [&](Association& association) {
    const double changed =
        association.object < 0 ? 1 : changed_shares[static_cast<std::size_t>(association.object)];
    if (association.known < 0) {
      if (changed < perception::kMajority) association.outcome = Outcome::kExplained;
      return false;
    }
    const auto k = static_cast<std::size_t>(association.known);
    const bool is_detected = association.support >= 0 || association.object >= 0;
    const WorldObject& known = *match.known[k];
    if (k >= scope.present) {
      // It is not in the world: without a detection there is nothing to say.
      if (association.outcome == Outcome::kKeep) {
        association.outcome = Outcome::kMove;
        association.X_WO = known.X_WO;
      }
      // What is gone and looks different now is another thing.
      if (is_detected && association.outcome == Outcome::kReplace) {
        association.outcome = Outcome::kAdd;
        association.known = -1;
        association.X_WO = Pose::Identity();
      }
      if (is_detected && changed < perception::kMajority) {
        association.outcome = Outcome::kExplained;
        association.known = -1;
      }
      return !is_detected;
    }
    const bool may_change = scope.may_change.contains(known.name) &&
                            (!is_detected || changed >= perception::kMinSignificantShare ||
                             scope.is_seen_through.contains(known.name));
    if (!may_change && association.outcome != Outcome::kExplained) {
      association.outcome = Outcome::kKeep;
    }
    return false;
  });
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

class RegionRun {
 public:
  RegionRun(World& world, const RegionJob& job, const perception::PointCloud& cloud,
            perception::SceneInterpretation scene, perception::NewSurfaces found,
            const SameSince& same_since, std::stop_token stop)
      : world_(world),
        job_(job),
        cloud_(cloud),
        scene_(std::move(scene)),
        found_(std::move(found)),
        same_since_(same_since),
        stop_(std::move(stop)),
        open_blocks_(found_.cut_blocks),
        detections_(scene_),
        geometry_(detections_) {}

  absl::StatusOr<RegionOutcome> Write() {
    const SnapshotPtr snapshot = world_.Tip();
    const Scope scope = ScopeOf(job_, *snapshot);
    match_ = MatchScene(snapshot, scope.known, scene_, cloud_, job_.frame.noise);
    if (job_.request.is_new_surface) {
      Restrict(match_, scope, std::vector<double>(scene_.objects.size(), 1));
    } else {
      RegionNews news = NewsOf(job_, scene_, same_since_(job_));
      Restrict(match_, scope, news.changed_shares);
      KeepHeld(match_, scope, MayRest(job_, scene_));
      open_blocks_ = std::move(news.outdated_blocks);
    }
    Grow();
    const perception::Work work{.max_threads = job_.max_threads,
                                .threads_now = job_.threads_now,
                                .stop = stop_,
                                .on_chunk = {}};
    if (auto ready = geometry_.PrepareFor(match_, IngestMode::kUpdate, work); !ready.ok()) {
      return ready;
    }
    std::vector<std::shared_ptr<const collision::PreparedModel>> geometry(
        geometry_.prepared().begin(), geometry_.prepared().end());
    for (const GrownObject& object : grown_) geometry.push_back(object.geometry);
    if (auto kept = world_.KeepGeometry(geometry, Durability::kObserved); !kept.ok()) {
      return kept;
    }
    auto written = world_.Update(
        [this](const SnapshotPtr& latest) { return Changes(*latest); }, {},
        {.facts = [this](const collision::WorldSnapshot& next) { return Facts(next); },
         .durability = Durability::kObserved});
    if (!written.ok()) return written.status();
    return OutcomeOf(*written, scope);
  }

 private:
  // An object that goes on where it was not seen before.
  struct GrownObject {
    WorldObjectPtr known;  // as the frame saw it
    std::shared_ptr<const collision::PreparedModel> geometry;
  };

  // A support that is a part of a known one now is that one.
  void Grow() {
    for (const perception::GrownBody& body : found_.grown) {
      const WorldObjectPtr known = job_.bodies->Find(body.body);
      if (known == nullptr || known->owner == collision::Owner::kUser) continue;
      grown_.push_back({known, collision::Prepare(body.model)});
      const auto place = std::ranges::find(match_.known, known->name,
                                           [](const WorldObjectPtr& each) { return each->name; });
      if (place == match_.known.end()) continue;
      for (Association& association : match_.associations) {
        if (std::ranges::find(body.supports, association.support) == body.supports.end()) continue;
        association.outcome = Outcome::kKeep;
        association.known = static_cast<int>(place - match_.known.begin());
        association.X_WO = known->X_WO;
      }
    }
  }

  // Those that nobody changed since the frame.
  void AddGrown(const collision::WorldSnapshot& latest) {
    for (const GrownObject& object : grown_) {
      const WorldObjectPtr now = latest.Find(object.known->name);
      if (now == nullptr || now->latest_revision() != object.known->latest_revision() ||
          now->attachment != nullptr) {
        continue;
      }
      plan_.replaced.push_back(now->name);
      plan_.changes.push_back({collision::PutObject{.name = now->name,
                                                    .kind = now->kind,
                                                    .owner = now->owner,
                                                    .state = now->state,
                                                    .X_WO = now->X_WO,
                                                    .geometry = object.geometry,
                                                    .supported_by = now->supported_by,
                                                    .margin_m = now->margin_m},
                               std::nullopt});
    }
  }

  absl::StatusOr<std::vector<Change>> Changes(const collision::WorldSnapshot& latest) {
    auto plan = PlanIngest(match_, detections_, IngestMode::kUpdate, geometry_,
                           [this](const std::string& stem) { return world_.ReserveName(stem); });
    if (!plan.ok()) return plan.status();
    plan_ = *std::move(plan);
    ChangesSince(*match_.snapshot, latest).DropFrom(plan_.changes);
    AddGrown(latest);
    return plan_.changes;
  }

  WriteFacts Facts(const collision::WorldSnapshot& next) const {
    WriteFacts facts;
    facts.seen_at = job_.frame.stamp;
    for (const auto* names : {&plan_.added, &plan_.moved, &plan_.replaced}) {
      for (const std::string& name : *names) {
        if (next.Find(name) != nullptr) facts.sightings.push_back({.name = name, .is_new = true});
      }
    }
    return facts;
  }

  RegionOutcome OutcomeOf(const WriteOutcome& written, const Scope& scope) const {
    RegionOutcome outcome{.revision = written.revision, .open_blocks = open_blocks_};
    outcome.changes.added = plan_.added;
    outcome.changes.replaced = plan_.replaced;
    outcome.changes.removed = plan_.removed;
    for (const std::string& name : plan_.moved) {
      const bool is_back = match_.snapshot->Find(name) == nullptr;
      (is_back ? outcome.changes.added : outcome.changes.moved).push_back(name);
    }
    for (std::size_t k = scope.present; k < scope.known.size(); ++k) {
      const std::string& name = scope.known[k]->name;
      if (Contains(plan_.moved, name) || Contains(plan_.replaced, name)) {
        outcome.returned.push_back(scope.known[k]);
      }
    }
    return outcome;
  }

  World& world_;
  const RegionJob& job_;
  const perception::PointCloud& cloud_;
  const perception::SceneInterpretation scene_;
  const perception::NewSurfaces found_;
  const SameSince& same_since_;
  const std::stop_token stop_;
  std::vector<std::int32_t> open_blocks_;
  const Detections detections_;
  DetectionGeometry geometry_;
  SceneMatch match_;
  IngestPlan plan_;
  std::vector<GrownObject> grown_;
};

// The bodies outside the request that explain points of their own.
std::vector<perception::KnownBody> Others(const RegionJob& job) {
  std::vector<perception::KnownBody> others;
  for (const perception::KnownBody& body : job.bodies->bodies) {
    const bool is_asked = std::ranges::binary_search(job.request.bodies, body.id);
    const bool is_mover = body.kind == perception::KnownBody::Kind::kMover;
    if (!is_asked && !is_mover) others.push_back(body);
  }
  return others;
}

perception::InterpretOptions OptionsOf(const RegionJob& job) {
  perception::InterpretOptions options;
  options.noise = job.frame.noise;
  options.X_WC = job.frame.X_WC;
  options.max_threads = job.max_threads;
  options.threads_now = job.threads_now;
  return options;
}

// The boxes of the followed bodies that have moved since, about both of their places.
std::vector<Aabb> WaysSince(const BodyTable& bodies, const collision::WorldSnapshot& now) {
  std::vector<Aabb> ways_W;
  for (const perception::KnownBody& body : bodies.bodies) {
    const WorldObjectPtr object = body.IsFollowed() ? now.Find(body.name) : nullptr;
    if (object == nullptr || object->X_WO.matrix() == body.X_WB.matrix()) continue;
    ways_W.push_back(TightBounds(*body.model, body.X_WB).merged(object->bounds_W));
  }
  return ways_W;
}

absl::StatusOr<RegionOutcome> IngestView(World& world, const RegionJob& job,
                                         perception::PointCloud cloud, const Interpreter& interpret,
                                         std::stop_token stop) {
  IngestRequest request;
  request.cloud = std::move(cloud);
  request.sensor = job.sensor;
  request.options = OptionsOf(job);
  // An estimated pose stays an estimate, and a given one what it was.
  const std::optional<SensorPose> kept = world.SensorPoseOf(job.sensor);
  const bool is_estimate =
      kept.has_value() && !kept->given && kept->X_WC.matrix() == job.X_WC_given.matrix();
  if (job.frame.X_WC.matrix() != job.X_WC_given.matrix()) {
    request.kept_pose = SensorPose{job.X_WC_given, !is_estimate};
  } else if (is_estimate) {
    request.options.X_WC.reset();
  }
  request.frame_stamp = job.frame.stamp;
  auto ingested = Ingest(world, request, interpret, std::move(stop));
  if (!ingested.ok()) return ingested.status();
  RegionOutcome outcome{.revision = ingested->revision};
  outcome.changes.added = ingested->added;
  outcome.changes.moved = ingested->moved;
  outcome.changes.replaced = ingested->replaced;
  outcome.changes.removed = ingested->removed;
  return outcome;
}

}  // namespace

absl::StatusOr<RegionOutcome> IngestRegion(World& world, const RegionJob& job,
                                           const Interpreter& interpret,
                                           const SameSince& same_since, std::stop_token stop) {
  const std::vector<perception::KnownBody> others = Others(job);
  perception::PointCloud cloud = perception::RegionCloud(job.frame, job.request, others);
  const bool is_empty =
      std::ranges::none_of(cloud.points, [](const Eigen::Vector3f& p) { return p.allFinite(); });
  if (is_empty) return RegionOutcome{.revision = world.Snapshot()->revision()};
  if (job.request.is_whole_view && !job.request.is_new_surface) {
    return IngestView(world, job, std::move(cloud), interpret, std::move(stop));
  }
  auto scene = interpret(cloud, OptionsOf(job), stop);
  if (!scene.ok()) return scene.status();
  if (stop.stop_requested()) return absl::CancelledError("live: the sensor's stream ended");
  perception::NewSurfaces found;
  if (job.request.is_new_surface) {
    found = perception::FindNewSurfaces(job.frame, job.bodies->bodies,
                                        WaysSince(*job.bodies, *world.Tip()), *scene);
  }
  return RegionRun(world, job, cloud, *std::move(scene), std::move(found), same_since,
                   std::move(stop))
      .Write();
}

}  // namespace cwm::server
