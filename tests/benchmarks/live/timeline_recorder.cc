#include "tests/benchmarks/live/timeline_recorder.h"

#include <algorithm>
#include <utility>

namespace cwm::benchmarks {
namespace {

Vector3 HalfSizeOf(const v1::Box& box) {
  return 0.5 * Vector3(box.size_x_m(), box.size_y_m(), box.size_z_m());
}

PlacedBox BoundsOf(const v1::Object& object) {
  return {.X_WB = PoseOf(object.x_world_object()) * PoseOf(object.bounds().x_object_box()),
          .half_size_m = HalfSizeOf(object.bounds().box())};
}

std::optional<PublishedKind> KindOf(const v1::Object& object) {
  switch (object.kind()) {
    case v1::OBJECT_KIND_OBJECT:
      return PublishedKind::kThing;
    case v1::OBJECT_KIND_RESIDUAL:
      return PublishedKind::kResidual;
    case v1::OBJECT_KIND_MOVER:
      return PublishedKind::kMover;
    default:
      return std::nullopt;
  }
}

}  // namespace

std::vector<PublishedThing> ThingsOf(const PublishedObjects& published) {
  std::vector<PublishedThing> things;
  for (const auto& [name, object] : published) {
    const auto kind = KindOf(*object);
    if (!kind) continue;
    const PlacedBox bounds = BoundsOf(*object);
    things.push_back({.name = name,
                      .kind = *kind,
                      .X_WO = PoseOf(object->x_world_object()),
                      .center_W = bounds.X_WB.translation(),
                      .diagonal_m = 2 * bounds.half_size_m.norm(),
                      .geometry_revision = object->geometry_revision(),
                      .is_moving = object->motion() == v1::MOTION_MOVING});
  }
  return things;
}

std::vector<TrueThing> TruthOf(const perception::SequenceScript& script, std::size_t first_thing,
                               const TrueFrame& frame) {
  std::vector<TrueThing> truth;
  for (std::size_t i = first_thing; i < script.scene.objects.size(); ++i) {
    perception::SimulatedObject object = script.scene.objects[i];
    object.X_WO = Pose::Identity();
    const Aabb bounds_O = perception::BoundsInWorld(object);
    const perception::ObjectTruth& state = frame.objects[i];
    truth.push_back({.X_WO = state.state.X_WO,
                     .center_W = state.state.X_WO * bounds_O.center(),
                     .diagonal_m = bounds_O.sizes().norm(),
                     .is_present = state.state.is_present,
                     .is_moving = state.state.is_moving || state.state.carrier.has_value(),
                     .visible_share = state.visible_share});
  }
  return truth;
}

std::optional<Recording> Record(LiveWorld& world, LiveSensor& sensor,
                                const perception::SequenceScript& script, std::size_t first_thing,
                                const std::vector<TrueFrame>& frames) {
  PublishedWorld& published = world.published();
  const std::size_t first = sensor.sent_count();
  if (!Play(sensor, frames)) return std::nullopt;
  Recording recording;
  const std::vector<FrameAnswer> answers = sensor.answers();
  recording.answers.assign(answers.begin() + static_cast<std::ptrdiff_t>(first), answers.end());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const FrameAnswer& answer = recording.answers[i];
    if (!answer.is_processed()) continue;
    if (!published.WaitFor(answer.response.revision())) return std::nullopt;
    PublishedObjects objects = published.At(answer.response.revision());
    recording.timeline.push_back({.stamp_s = frames[i].frame.stamp_s,
                                  .truth = TruthOf(script, first_thing, frames[i]),
                                  .published = ThingsOf(objects)});
    recording.published.push_back(std::move(objects));
    recording.frames.push_back(i);
  }
  return recording;
}

Pose PoseOf(const v1::Pose& pose) {
  const Quaternion q(pose.qw(), pose.qx(), pose.qy(), pose.qz());
  if (q.norm() < 0.5) return Pose::Identity();
  return MakePose({pose.tx_m(), pose.ty_m(), pose.tz_m()}, q.normalized());
}

std::vector<PlacedBox> BoxesOf(const v1::Object& object) {
  std::vector<PlacedBox> boxes;
  for (const v1::ShapePart& part : object.shapes()) {
    if (!part.has_box()) return {BoundsOf(object)};
    boxes.push_back({.X_WB = PoseOf(object.x_world_object()) * PoseOf(part.x_object_shape()),
                     .half_size_m = HalfSizeOf(part.box())});
  }
  if (boxes.empty()) boxes.push_back(BoundsOf(object));
  return boxes;
}

double Distance_m(const PlacedBox& box, const Vector3& p_W) {
  const Vector3 p_B = box.X_WB.inverse() * p_W;
  return (p_B.cwiseAbs() - box.half_size_m).cwiseMax(0).norm();
}

}  // namespace cwm::benchmarks
