// A gripper and the things beside it: what it lifts is followed though nobody attached it, and what
// it passes or pushes is not taken for carried.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "perception/simulation/scenes.h"
#include "tests/perception/live/gripper.h"
#include "tests/perception/live/tracked_sequence.h"

namespace cwm::perception {
namespace {

using Kind = TrackChange::Kind;

// A table with things before a still Kinect, and the thing that the gripper is about.
struct GripperScene {
  SequenceScript script = {};
  std::size_t thing = 0;
  Aabb bounds_W = {};

  explicit GripperScene(std::uint64_t seed) {
    script.scene = RandomTable(seed, 6);
    script.seed = seed;
    SequenceSensor sensor;
    sensor.name = "head";
    sensor.camera = KitchenCamera();
    sensor.mount = KitchenCamera().X_WC;
    sensor.device_seed = seed;
    script.sensors.push_back(sensor);
    thing = 1 + seed % (script.scene.objects.size() - 1);
    bounds_W = BoundsInWorld(script.scene.objects[thing]);
  }
  // Fingers close along the shorter side.
  double yaw_rad() const {
    return bounds_W.sizes().x() < bounds_W.sizes().y() ? std::numbers::pi / 2 : 0;
  }
  double half_width_m() const { return 0.5 * std::min(bounds_W.sizes().x(), bounds_W.sizes().y()); }
  BodyId id() const { return static_cast<BodyId>(thing); }
};

struct CarryTimes {
  double lift_s = 2.8, put_s = 5.5, away_s = 7;
};

// The gripper takes the thing from above, lifts it by 0.2 m, turns and moves it, holds it still,
// puts it back and goes away.
GripperScene Lifted(std::uint64_t seed, const CarryTimes& times) {
  GripperScene scene(seed);
  const Vector3 grasp_W(scene.bounds_W.center().x(), scene.bounds_W.center().y(),
                        scene.bounds_W.max().z() + 0.03);
  const double yaw = scene.yaw_rad();
  const double closed_m = scene.half_width_m() + 0.001, open_m = closed_m + 0.03;
  const double travel_s = (times.put_s - times.lift_s) / 5;
  const auto above = [&](double x, double y, double z) {
    return Vector3(grasp_W + Vector3(x, y, z));
  };
  std::vector<GripperPose> path = {{0, above(0.1, 0.1, 0.5), yaw, open_m},
                                   {1.5, above(0, 0, 0.3), yaw, open_m},
                                   {2.3, grasp_W, yaw, open_m},
                                   {2.6, grasp_W, yaw, closed_m},
                                   {times.lift_s, grasp_W, yaw, closed_m}};
  double time_s = times.lift_s;
  for (const auto& [place_W, turn] :
       {std::pair(above(0, 0, 0.2), 0.0), std::pair(above(-0.1, 0.1, 0.2), 1.0),
        std::pair(above(-0.1, 0.1, 0.2), 1.0), std::pair(above(0, 0.05, 0.15), 0.5),
        std::pair(grasp_W, 0.0)}) {
    time_s += travel_s;
    path.push_back({time_s, place_W, yaw + turn, closed_m});
  }
  path.push_back({times.put_s + 0.3, grasp_W, yaw, open_m});
  path.push_back({times.put_s + 0.6, grasp_W, yaw, open_m});
  path.push_back({times.away_s, above(0, 0, 0.4), yaw, open_m});
  scene.script.robots.push_back(SimulateGripper(path));
  scene.script.events.push_back({.object = scene.thing,
                                 .begin_s = times.lift_s,
                                 .end_s = times.put_s,
                                 .what = CarryEvent{LinkRef{0, kPalm}}});
  scene.script.duration_s = times.away_s + 1;
  return scene;
}

const KnownBody* Find(const TrackedFrame& frame, BodyId id) {
  const auto found = std::ranges::find(frame.bodies, id, &KnownBody::id);
  return found == frame.bodies.end() ? nullptr : &*found;
}

double Error_m(const TrackedFrame& frame, const GripperScene& scene) {
  SimulatedObject thing = scene.script.scene.objects[scene.thing];
  thing.X_WO = Pose::Identity();
  const Vector3 center_O = BoundsInWorld(thing).center();
  const KnownBody* const body = Find(frame, scene.id());
  if (body == nullptr) return std::numeric_limits<double>::infinity();
  return (body->X_WB * center_O - frame.truth[scene.thing].state.X_WO * center_O).norm();
}

TEST(Carrying, FollowsWhatAGripperLifts) {
  for (const std::uint64_t seed : {1U, 2U, 10U}) {  // a box, a ball and a can
    const CarryTimes times;
    const GripperScene scene = Lifted(seed, times);
    TrackedSequence sequence(scene.script);
    for (const TrackedFrame& frame : sequence.Run()) {
      const double time_s = FrameTime_s(scene.script.sensors.front(), frame.frame);
      const TrackedFacts facts =
          frame.facts.contains(scene.id()) ? frame.facts.at(scene.id()) : TrackedFacts();
      const auto where = testing::Message() << "seed " << seed << ", frame " << frame.frame;
      if (frame.truth[scene.thing].visible_share >= 0.15) {
        EXPECT_LT(Error_m(frame, scene), 0.01) << where;
      }
      if (time_s < times.lift_s || time_s > times.away_s) {
        EXPECT_EQ(facts.carried_by, "") << where;
      }
      if (time_s > times.lift_s + 0.2 && time_s < times.put_s) {
        EXPECT_EQ(facts.carried_by, "gantry/palm") << where;
      }
      EXPECT_EQ(std::ranges::count(frame.changes, Kind::kRemove, &TrackChange::kind), 0) << where;
    }
    EXPECT_EQ(sequence.tracker().FactsOf(scene.id()).motion, Motion::kAtRest);
  }
}

TEST(Carrying, SaysSoWhileItMovesAndRestsWhileTheGripperHoldsStill) {
  const CarryTimes times{
      .lift_s = 2.8, .put_s = 7.8, .away_s = 9.3};  // it holds still from 4.8 to 5.8 s
  const GripperScene scene = Lifted(2, times);
  TrackedSequence sequence(scene.script);
  for (const TrackedFrame& frame : sequence.Run()) {
    const double time_s = FrameTime_s(scene.script.sensors.front(), frame.frame);
    const bool is_moved = std::ranges::any_of(
        frame.changes, [&](const TrackChange& change) { return change.body == scene.id(); });
    if (time_s > 3.0 && time_s < 4.7) {
      EXPECT_EQ(frame.facts.at(scene.id()).motion, Motion::kMoving) << frame.frame;
      EXPECT_TRUE(is_moved) << frame.frame;
    }
    if (time_s > 5.2 && time_s < 5.8) {
      EXPECT_EQ(frame.facts.at(scene.id()).motion, Motion::kAtRest) << frame.frame;
      EXPECT_EQ(frame.facts.at(scene.id()).carried_by, "gantry/palm") << frame.frame;
    }
  }
}

TEST(Carrying, TakesNothingThatTheGripperOnlyPasses) {
  for (const std::uint64_t seed : {1U, 8U}) {
    GripperScene scene(seed);
    const Vector3 center_W = scene.bounds_W.center();
    // The tips pass 10 mm above it, to and fro.
    const double height_m = scene.bounds_W.max().z() + 0.09;
    std::vector<GripperPose> path;
    for (int k = 0; k < 6; ++k) {
      const double x = center_W.x() + (k % 2 == 0 ? -0.4 : 0.3);
      path.push_back({1.5 + k, {x, center_W.y(), height_m}, scene.yaw_rad(), 0.02});
    }
    scene.script.robots.push_back(SimulateGripper(path));
    scene.script.duration_s = 7;
    for (const TrackedFrame& frame : TrackedSequence(scene.script).Run()) {
      for (const TrackChange& change : frame.changes) {
        EXPECT_EQ(change.kind, Kind::kMovers) << "seed " << seed << ", frame " << frame.frame;
      }
      for (const auto& [id, facts] : frame.facts) EXPECT_EQ(facts.carried_by, "") << frame.frame;
    }
  }
}

TEST(Carrying, FollowsWhatAFingerPushesButDoesNotCallItCarried) {
  for (const std::uint64_t seed : {1U, 6U}) {
    GripperScene scene(seed);
    const Vector3 center_W = scene.bounds_W.center();
    const double begin_s = 2.5, end_s = 3.5, way_m = 0.1;
    const double behind_x = scene.bounds_W.min().x() - 0.01;  // half a finger is 10 mm
    const double height_m = scene.bounds_W.min().z() + 0.1;
    const auto at = [&](double x, double up_m) {
      return Vector3(behind_x + x, center_W.y(), height_m + up_m);
    };
    scene.script.robots.push_back(SimulateGripper({{0, at(-0.3, 0.4), 0, 0.02},
                                                   {1.5, at(-0.1, 0.2), 0, 0.02},
                                                   {2, at(-0.1, 0), 0, 0.02},
                                                   {begin_s, at(0, 0), 0, 0.02},
                                                   {end_s, at(way_m, 0), 0, 0.02},
                                                   {4, at(-0.05, 0), 0, 0.02},
                                                   {4.5, at(-0.1, 0.4), 0, 0.02}}));
    Pose X_WO_end = scene.script.scene.objects[scene.thing].X_WO;
    X_WO_end.translation().x() += way_m;
    scene.script.events.push_back(
        {.object = scene.thing, .begin_s = begin_s, .end_s = end_s, .what = MoveEvent{X_WO_end}});
    scene.script.duration_s = 5.5;
    const std::vector<TrackedFrame> frames = TrackedSequence(scene.script).Run();
    for (const TrackedFrame& frame : frames) {
      for (const auto& [id, facts] : frame.facts) EXPECT_EQ(facts.carried_by, "") << frame.frame;
    }
    EXPECT_LT(Error_m(frames.back(), scene), 0.005) << "seed " << seed;
  }
}

}  // namespace
}  // namespace cwm::perception
