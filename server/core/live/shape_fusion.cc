#include "server/core/live/shape_fusion.h"

#include <algorithm>
#include <utility>

namespace cwm::server {
namespace {

using collision::WorldObjectPtr;
using perception::BodyId;
using perception::KnownBody;
using perception::Stamp;

// chosen: a sensor that shows less of an object adds nothing to its shape.
constexpr int kMinExpected_px = 100;
// chosen: the share of an object's surface that must be measured more than before.
constexpr double kMinGain = 0.02;

// Merged views do not tell what is hollow: a ball, a box or a cylinder, of which one view showed
// that it is solid, stays solid.
bool IsKnownSolid(const HybridModel& model) {
  if (model.shapes.size() != 1 || model.shapes.front().vessel != nullptr) return false;
  const Shape& shape = model.shapes.front().shape;
  return std::holds_alternative<Sphere>(shape) || std::holds_alternative<Box>(shape) ||
         std::holds_alternative<Cylinder>(shape);
}

// The mean share of the shapes' surfaces that was measured.
double ObservedShare(const HybridModel& model) {
  double sum = 0;
  for (const ShapePart& part : model.shapes) {
    if (part.fit.has_value()) sum += part.fit->observed_fraction;
  }
  return model.shapes.empty() ? 0 : sum / static_cast<double>(model.shapes.size());
}

class Fusing {
 public:
  Fusing(World& world, const FusionJob& job, const Interpreter& interpret, std::stop_token stop)
      : world_(world), job_(job), interpret_(interpret), stop_(std::move(stop)) {
    for (std::size_t i = 0; i < job.views.size(); ++i) {
      perception::MeanView view = job.views[i];
      view.depth_m = perception::MeanAtRest(job.frames[i], view.camera, view.noise);
      views_.push_back(std::move(view));
    }
  }

  absl::Status Fuse(BodyId target) {
    const auto found = std::ranges::find(job_.bodies->bodies, target, &KnownBody::id);
    if (found == job_.bodies->bodies.end() || removed_.contains(target)) return absl::OkStatus();
    const KnownBody& body = *found;
    std::set<BodyId> parts = PartsOf(body);
    const auto object = Fit(body, parts);
    if (!object.ok()) return object.status();
    if (object->has_value()) {
      KnownBody fitted = body;
      fitted.model = (*object)->model;
      fitted.X_WB = (*object)->X_WO;
      parts.merge(PartsOf(fitted));
    }
    if (!object->has_value() && parts.empty()) return absl::OkStatus();
    return Write(target, *object, parts);
  }

  FrameChanges TakeChanges() { return std::move(changes_); }

 private:
  std::set<BodyId> PartsOf(const KnownBody& body) const {
    const std::vector<BodyId> parts = perception::PartsOf(views_, body, job_.bodies->bodies);
    return {parts.begin(), parts.end()};
  }

  // The body as all views show it, with the points of its parts; empty if that is no better.
  absl::StatusOr<std::optional<perception::DetectedObject>> Fit(const KnownBody& body,
                                                                const std::set<BodyId>& parts) {
    std::vector<KnownBody> bodies;
    for (const KnownBody& each : job_.bodies->bodies) {
      if (!parts.contains(each.id)) bodies.push_back(each);
    }
    const perception::FusionCloud fused = perception::CloudOfBody(views_, body, bodies);
    if (fused.cloud.points.empty()) return std::nullopt;
    perception::InterpretOptions options;
    options.noise = views_.front().noise;
    options.X_WC = fused.X_WC;
    options.max_threads = job_.max_threads;
    options.modeler.reduced_effort = IsKnownSolid(*body.model);
    const auto scene = interpret_(fused.cloud, options, stop_);
    if (stop_.stop_requested()) return absl::CancelledError("live: the sensor's stream ended");
    if (!scene.ok()) return std::nullopt;  // it stays as one sensor sees it
    auto object = perception::FusedObject(fused, *scene, body, bodies, options.noise);
    if (object && ObservedShare(*object->model) < ObservedShare(*body.model) + kMinGain) {
      return std::nullopt;
    }
    return object;
  }

  // One revision, unless somebody changed the object meanwhile; parts that somebody changed stay.
  absl::Status Write(BodyId target, const std::optional<perception::DetectedObject>& object,
                     const std::set<BodyId>& parts) {
    const auto geometry = object ? collision::Prepare(object->model) : nullptr;
    std::vector<BodyId> removed;
    bool is_same = false;
    const auto make =
        [&](const SnapshotPtr& latest) -> absl::StatusOr<std::vector<collision::Change>> {
      std::vector<collision::Change> changes;
      removed.clear();
      const WorldObjectPtr now = Unchanged(target, *latest);
      is_same = now != nullptr;
      if (!is_same) return changes;
      if (object) {
        changes.push_back({collision::PutObject{.name = now->name,
                                                .kind = now->kind,
                                                .owner = now->owner,
                                                .state = collision::ObjectState::kConfirmed,
                                                .X_WO = object->X_WO,
                                                .geometry = geometry,
                                                .supported_by = now->supported_by,
                                                .margin_m = now->margin_m},
                           std::nullopt});
      }
      for (const BodyId part : parts) {
        const WorldObjectPtr other = Unchanged(part, *latest);
        if (other == nullptr) continue;
        removed.push_back(part);
        changes.push_back({collision::RemoveObject{other->name}, std::nullopt});
      }
      return changes;
    };
    const auto written = world_.Update(make, {}, {.durability = Durability::kObserved});
    if (!written.ok()) return written.status();
    if (is_same && object) changes_.replaced.push_back(job_.bodies->Find(target)->name);
    for (const BodyId part : removed) {
      changes_.removed.push_back(job_.bodies->Find(part)->name);
      removed_.insert(part);
    }
    return absl::OkStatus();
  }

  // The object if it is as it was when the frames were compared, and nobody carries it.
  WorldObjectPtr Unchanged(BodyId id, const collision::WorldSnapshot& latest) const {
    const WorldObjectPtr seen = job_.bodies->Find(id);
    const WorldObjectPtr now = latest.Find(seen->name);
    const bool is_same = now != nullptr && now->IsSameAs(*seen) && now->attachment == nullptr &&
                         now->latest_revision() == seen->latest_revision();
    return is_same ? now : nullptr;
  }

  World& world_;
  const FusionJob& job_;
  const Interpreter& interpret_;
  const std::stop_token stop_;
  std::vector<perception::MeanView> views_;
  FrameChanges changes_;
  std::set<BodyId> removed_;
};

}  // namespace

absl::StatusOr<FrameChanges> FuseShapes(World& world, const FusionJob& job,
                                        const Interpreter& interpret, std::stop_token stop) {
  Fusing fusing(world, job, interpret, std::move(stop));
  for (const BodyId target : job.targets) {
    if (absl::Status fused = fusing.Fuse(target); !fused.ok()) return fused;
  }
  return fusing.TakeChanges();
}

void ShapeFusion::Add(const perception::FrameEvidence& frame,
                      const std::shared_ptr<const BodyTable>& bodies,
                      const std::set<BodyId>& moving) {
  if (!frame.is_still || !frame.has_reference) return;
  sensors_.insert(frame.sensor);
  if (sensors_.size() < 2) return;
  bodies_ = bodies;
  const auto collects = collected_.find(frame.sensor);
  if (collects != collected_.end() && collects->second.frames.size() < kFrames) {
    Collected& collected = collects->second;
    if (collected.frames.empty() || collected.view.X_WC.matrix() != frame.X_WC.matrix()) {
      collected = {};
      collected.view = {
          .sensor = frame.sensor, .X_WC = frame.X_WC, .camera = frame.camera, .noise = frame.noise};
    }
    collected.frames.push_back({.image = frame.image, .classes = frame.classes});
    collected.last = frame.stamp;
  }
  std::erase_if(objects_,
                [&](const auto& entry) { return bodies->snapshot->Find(entry.first) == nullptr; });
  for (const perception::BodyEvidence& evidence : frame.bodies) {
    const auto known = std::ranges::find(bodies->bodies, evidence.id, &KnownBody::id);
    if (known == bodies->bodies.end() || known->kind != KnownBody::Kind::kObject) continue;
    Object& object = objects_[known->name];
    const WorldObjectPtr& now =
        bodies->objects[static_cast<std::size_t>(known - bodies->bodies.begin())];
    const bool is_other = object.object == nullptr || !now->IsSameAs(*object.object) ||
                          now->latest_revision() != object.object->latest_revision();
    if (is_other || moving.contains(evidence.id)) {
      object.since = frame.stamp;
      object.seen.clear();
    }
    if (object.was_replaced && object.object->geometry != now->geometry) {
      object.tried = now->geometry;
      object.was_replaced = false;
    }
    object.object = now;
    const bool is_seen = evidence.expected >= kMinExpected_px &&
                         2 * evidence.consistent >= evidence.expected - evidence.hidden;
    if (is_seen) object.seen[frame.sensor] = frame.stamp;
  }
  if (targets_.empty() && !is_running_) Begin(frame.stamp, *bodies);
}

bool ShapeFusion::IsDue(const Object& object, Stamp now, std::set<std::string>& sensors) const {
  if (now - object.since < kRestTime - kCollectTime) return false;
  sensors.clear();
  for (const auto& [sensor, stamp] : object.seen) {
    if (now - stamp <= kSeenTime) sensors.insert(sensor);
  }
  if (sensors.size() < 2) return false;
  const bool is_tried = object.tried == object.object->geometry &&
                        std::ranges::includes(object.tried_sensors, sensors);
  return !is_tried;
}

void ShapeFusion::Begin(Stamp now, const BodyTable& bodies) {
  collected_.clear();
  std::set<std::string> sensors;
  for (const KnownBody& body : bodies.bodies) {
    const auto found = objects_.find(body.name);
    if (found == objects_.end() || !IsDue(found->second, now, sensors)) continue;
    targets_.insert(body.name);
    for (const std::string& sensor : sensors) collected_[sensor].last = now;
  }
}

std::optional<FusionJob> ShapeFusion::TakeJob() {
  if (is_running_ || targets_.empty()) return std::nullopt;
  Stamp newest;
  for (const auto& [sensor, collected] : collected_) newest = std::max(newest, collected.last);
  // A sensor that fell silent is not waited for.
  std::erase_if(collected_, [&](const auto& entry) {
    return entry.second.frames.size() < kFrames && newest - entry.second.last > kRestTime;
  });
  if (collected_.size() < 2) {
    targets_.clear();
    return std::nullopt;
  }
  if (std::ranges::any_of(collected_,
                          [](const auto& entry) { return entry.second.frames.size() < kFrames; })) {
    return std::nullopt;
  }
  FusionJob job{.bodies = bodies_};
  std::set<std::string> sensors;
  for (auto& [sensor, collected] : collected_) {
    job.views.push_back(std::move(collected.view));
    job.frames.push_back(std::move(collected.frames));
    sensors.insert(sensor);
  }
  collected_.clear();
  for (const KnownBody& body : bodies_->bodies) {
    const auto found = objects_.find(body.name);
    if (!targets_.contains(body.name) || found == objects_.end()) continue;
    Object& object = found->second;
    // It has rested since before the first of the frames.
    if (newest - object.since < kRestTime) continue;
    object.tried = object.object->geometry;
    object.tried_sensors = sensors;
    job.targets.push_back(body.id);
  }
  targets_.clear();
  is_running_ = !job.targets.empty();
  return is_running_ ? std::optional(std::move(job)) : std::nullopt;
}

void ShapeFusion::Finish(const std::vector<std::string>& replaced) {
  is_running_ = false;
  for (const std::string& name : replaced) {
    const auto found = objects_.find(name);
    if (found != objects_.end()) found->second.was_replaced = true;
  }
}

void ShapeFusion::Forget(const std::string& sensor) {
  sensors_.erase(sensor);
  collected_.erase(sensor);
  for (auto& [name, object] : objects_) object.seen.erase(sensor);
}

}  // namespace cwm::server
