// A hand over the table: what is published of it, and what is not changed by it.
#include <algorithm>
#include <numbers>
#include <set>
#include <string>
#include <utility>

#include "perception/simulation/hand.h"
#include "tests/benchmarks/live/judge.h"
#include "tests/benchmarks/live/live_benchmarks.h"
#include "tests/benchmarks/live/live_scenes.h"
#include "tests/benchmarks/live/timeline_recorder.h"
#include "tests/benchmarks/server/server_benchmarks.h"

namespace cwm::benchmarks {
namespace {

using perception::SequenceScript;

constexpr double kNear_m = 0.03;
constexpr double kFirst_s = 4;
constexpr int kStillFrames = 60;  // before any hand
constexpr int kPointStep = 7;     // one of so many pixels of the hand is measured

// A hand pushes one thing, takes another, and puts it back beside its place.
SequenceScript HandOverTable() {
  SequenceScript script = TableScript({.thing_count = 12, .duration_s = 22, .seed = 3});
  const std::size_t pushed = kFirstThing + 2, taken = kFirstThing + 6;
  const Pose pushed_to = MakeTranslation(-0.06, 0, 0) * script.scene.objects[pushed].X_WO;
  const Pose put_at = MakeTranslation(0.01, 0.01, 0) * script.scene.objects[taken].X_WO;
  const perception::HandReach reach{.from_W = perception::ReachFrom(script, pushed, kFirst_s)};
  perception::PushByHand(pushed, {.begin_s = kFirst_s, .end_s = kFirst_s + 2}, pushed_to, reach,
                         script);
  perception::TakeByHand(taken, kFirst_s + 6, reach, script);
  perception::PutByHand(taken, kFirst_s + 12, put_at, reach, script);
  return script;
}

// The shortest distance of a point from the hand's capsules.
double DistanceFromHand_m(const perception::SimulatedObject& hand, const Pose& X_WH,
                          const Vector3& p_W) {
  const Vector3 p_H = X_WH.inverse() * p_W;
  double distance_m = 1e9;
  for (const Placed<>& part : hand.parts) {
    const auto* capsule = std::get_if<Capsule>(&part.shape);
    if (capsule == nullptr) continue;  // a hand has no other parts
    const Vector3 p_S = part.X_FS.inverse() * p_H;
    const double half_m = 0.5 * capsule->length_m;
    const Vector3 on_axis(0, 0, std::clamp(p_S.z(), -half_m, half_m));
    distance_m = std::min(distance_m, (p_S - on_axis).norm() - capsule->radius_m);
  }
  return std::max(distance_m, 0.0);
}

// Overlaps of its capsules count twice, so that it is an upper bound.
double VolumeOf_m3(const perception::SimulatedObject& hand) {
  double volume_m3 = 0;
  for (const Placed<>& part : hand.parts) {
    if (const auto* capsule = std::get_if<Capsule>(&part.shape)) {
      const double r_m = capsule->radius_m;
      volume_m3 += std::numbers::pi * r_m * r_m * (capsule->length_m + 4 * r_m / 3);
    }
  }
  return volume_m3;
}

std::vector<PlacedBox> UnmodelledBoxes(const PublishedObjects& published) {
  std::vector<PlacedBox> boxes;
  for (const auto& [name, object] : published) {
    if (object->kind() != v1::OBJECT_KIND_MOVER && object->kind() != v1::OBJECT_KIND_RESIDUAL) {
      continue;
    }
    for (const PlacedBox& box : BoxesOf(*object)) boxes.push_back(box);
  }
  return boxes;
}

// The volume of the boxes beyond kNear_m of the hand, on a grid of 2 cm.
double FarVolume_m3(const std::vector<PlacedBox>& boxes, const perception::SimulatedHand& hand,
                    const Pose& X_WH) {
  constexpr double kCell_m = 0.02;
  double volume_m3 = 0;
  for (const PlacedBox& box : boxes) {
    const Eigen::Array3i counts = (2 * box.half_size_m / kCell_m).array().ceil().cast<int>().max(1);
    const Vector3 cell_m = 2 * box.half_size_m.array() / counts.cast<double>();
    for (int i = 0; i < counts.x(); ++i) {
      for (int j = 0; j < counts.y(); ++j) {
        for (int k = 0; k < counts.z(); ++k) {
          const Vector3 p_B =
              (Eigen::Array3d(i, j, k) + 0.5) * cell_m.array() - box.half_size_m.array();
          if (DistanceFromHand_m(hand.shape, X_WH, box.X_WB * p_B) > kNear_m) {
            volume_m3 += cell_m.prod();
          }
        }
      }
    }
  }
  return volume_m3;
}

struct HandSums {
  long points = 0, covered = 0;
  std::vector<double> excess;   // by frame, of the hand's own volume
  std::vector<double> gone_ms;  // by leave
};

// A hand that left is gone when no mover or residual is published that was not there before it.
void MeasureFrames(const perception::SequenceRenderer& renderer,
                   const std::vector<TrueFrame>& frames, double first_stamp_s,
                   const Recording& recording, HandSums& sums) {
  const SequenceScript& script = renderer.script();
  bool was_seen = false;
  double left_s = -1;
  std::set<std::string> before;  // the hand came
  for (std::size_t m = 0; m < recording.timeline.size(); ++m) {
    const TrueFrame& frame = frames[recording.frames[m]];
    const double time_s = frame.frame.stamp_s - first_stamp_s;
    const std::vector<PlacedBox> boxes = UnmodelledBoxes(recording.published[m]);
    for (std::size_t pixel = 0; pixel < frame.bodies.size(); pixel += kPointStep) {
      const std::int32_t body = frame.bodies[pixel];
      if (body < 0 || renderer.bodies()[static_cast<std::size_t>(body)].kind !=
                          perception::SequenceBody::Kind::kHand) {
        continue;
      }
      const Vector3 p_W = PointInWorld(frame.frame, pixel);
      ++sums.points;
      sums.covered += std::ranges::any_of(
          boxes, [&](const PlacedBox& box) { return Distance_m(box, p_W) <= kNear_m; });
    }
    const perception::SequenceState state = perception::StateAt(script, time_s);
    for (std::size_t h = 0; h < state.X_WH.size(); ++h) {
      if (!state.X_WH[h]) continue;
      sums.excess.push_back(FarVolume_m3(boxes, script.hands[h], *state.X_WH[h]) /
                            VolumeOf_m3(script.hands[h].shape));
    }
    const bool is_seen = frame.hand_pixels > 0;
    if (is_seen && !was_seen && m > 0) {
      before.clear();
      for (const PublishedThing& thing : recording.timeline[m - 1].published) {
        before.insert(thing.name);
      }
    }
    if (was_seen && !is_seen) left_s = time_s;
    const bool has_mover =
        std::ranges::any_of(recording.timeline[m].published, [&](const PublishedThing& thing) {
          return thing.kind != PublishedKind::kThing && !before.contains(thing.name);
        });
    if (left_s >= 0 && (!has_mover || is_seen)) {
      sums.gone_ms.push_back(1e3 * (time_s - left_s));
      left_s = -1;
    }
    was_seen = is_seen;
  }
  if (left_s >= 0) sums.gone_ms.push_back(1e4);
}

}  // namespace

void MeasureLiveHand(Report& report) {
  const perception::SequenceRenderer renderer(HandOverTable());
  const SequenceScript& script = renderer.script();
  auto frames = RenderFrames(renderer, 0, 0, static_cast<int>(script.duration_s * 30),
                             /*keeps_bodies=*/true);
  LiveWorld world;
  if (!world.up()) return report.Fail("the server does not come up");
  std::vector<TrueFrame> still(frames.begin(), frames.begin() + kStillFrames);
  frames.erase(frames.begin(), frames.begin() + kStillFrames);
  LiveSensor& sensor = world.AddSensor("camera_1", frames.front().frame);
  if (const std::string error = Settle(world, sensor, still); !error.empty()) {
    return report.Fail(error);
  }
  MoveToPresent(frames);
  // Of the script's time 0.
  const double first_stamp_s = frames.front().frame.stamp_s - kStillFrames / 30.0;
  const auto recording = Record(world, sensor, script, kFirstThing, frames);
  if (!recording) return report.Fail("the stream ended: " + sensor.Finish());
  HandSums sums;
  MeasureFrames(renderer, frames, first_stamp_s, *recording, sums);
  if (sums.points == 0 || sums.gone_ms.empty()) return report.Fail("no hand was seen");
  report.Add(WithLimit(
      {.key = "live_movers_covered",
       .value = 1e2 * static_cast<double>(sums.covered) / static_cast<double>(sums.points),
       .unit = "%",
       .how = "of the points of a hand, those within 30 mm of a mover or residual that the same "
              "frame's revision has; it pushes, takes and puts things in 22 s"},
      99, "at least"));
  report.Add(WithLimit({.key = "live_movers_excess",
                        .value = Quantile(sums.excess, 0.95),
                        .unit = "x",
                        .how = "p95 over the frames of the volume of movers and residuals beyond "
                               "30 mm of the hand, to that of the hand"},
                       2));
  report.Add(WithLimit({.key = "live_movers_gone_ms",
                        .value = *std::ranges::max_element(sums.gone_ms),
                        .unit = "ms",
                        .how = "the longest of " + std::to_string(sums.gone_ms.size()) +
                               " times from the first frame without the hand to that without a "
                               "mover or a residual that was not there before"},
                       66));
  const ChangeVerdict changes = JudgeChanges(recording->timeline, 1);
  for (const std::string& line : changes.lines) report.Detail("  hand: " + line);
  const ChangeCounts& unfounded = changes.unfounded;
  report.Add(WithLimit({.key = "live_movers_shapes",
                        .value = static_cast<double>(unfounded.added),
                        .unit = "1",
                        .how = "objects added while the hand was at the table that are no thing"},
                       0));
  report.Add(WithLimit(
      {.key = "live_hand_false_changes",
       .value = 1e3 * unfounded.sum() / static_cast<double>(recording->timeline.size()),
       .unit = "1/1000",
       .how = "changes without an event of their thing per 1 000 frames, beside a hand; removed " +
              std::to_string(unfounded.removed) + ", moved " + std::to_string(unfounded.moved) +
              ", replaced " + std::to_string(unfounded.replaced)},
      0.1));
}

}  // namespace cwm::benchmarks
