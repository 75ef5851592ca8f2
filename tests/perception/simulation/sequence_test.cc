#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "perception/simulation/deliveries.h"
#include "perception/simulation/hand.h"
#include "perception/simulation/scenes.h"
#include "perception/simulation/sequence_renderer.h"

namespace cwm::perception {
namespace {

constexpr double kRounding_m = 1e-12;  // of products of a few poses

std::size_t ObjectNamed(const SequenceScript& script, const std::string& name) {
  const auto& objects = script.scene.objects;
  return static_cast<std::size_t>(
      std::find_if(objects.begin(), objects.end(),
                   [&](const SimulatedObject& object) { return object.name == name; }) -
      objects.begin());
}

// The demo's kitchen counter, seen by a small camera at the demo's place.
SequenceScript Kitchen(double duration_s) {
  SequenceScript script{.scene = KitchenCounter(), .duration_s = duration_s};
  SequenceSensor sensor{.name = "front", .mount = KitchenCamera().X_WC};
  sensor.camera = {
      .width = 320, .height = 240, .focal_px = 262.5, .center_x_px = 159.5, .center_y_px = 119.5};
  script.sensors = {sensor};
  return script;
}

// A robot that slides a ball along y: 0.1 m a second, from one side of the counter.
SimulatedRobot Slider() {
  SimulatedRobot robot{.name = "slider", .variables = {"slide"}};
  robot.links = {{.name = "rail", .parts = {}},
                 {.name = "ball", .parts = {{.shape = Sphere{.radius_m = 0.06}}}}};
  robot.link_poses = [](std::span<const double> values) {
    return std::vector<Pose>{Pose::Identity(), MakeTranslation(0.5, -0.4 + values[0], 1.1)};
  };
  robot.trajectory = {.times_s = {0, 10}, .rows = {{0}, {1}}};
  return robot;
}

void ExpectSameFrames(const SequenceFrame& a, const SequenceFrame& b) {
  EXPECT_EQ(a.depth.depth_m, b.depth.depth_m);
  EXPECT_EQ(a.depth.object, b.depth.object);
  ASSERT_EQ(a.objects.size(), b.objects.size());
  for (std::size_t i = 0; i < a.objects.size(); ++i) {
    EXPECT_EQ(a.objects[i].pixel_count, b.objects[i].pixel_count);
    EXPECT_EQ(a.objects[i].visible_share, b.objects[i].visible_share);
  }
}

TEST(Sequence, GivesTheSameFramesInAnyOrder) {
  SequenceScript script = Kitchen(1);
  TakeByHand(ObjectNamed(script, "tea"), 0.5, {.from_W = {0.5, -0.6, 1.4}}, script);
  const SequenceRenderer forwards(script);
  const SequenceRenderer backwards(script);
  const SequenceFrame second = backwards.Render(0, 20);
  const SequenceFrame first = backwards.Render(0, 2);
  ExpectSameFrames(forwards.Render(0, 2), first);
  ExpectSameFrames(forwards.Render(0, 20), second);
}

// What does not move is rendered once for a fixed sensor, and in each frame for a moving one.
TEST(Sequence, GivesAFixedSensorTheFramesOfAMovingOneThatStands) {
  SequenceScript script = Kitchen(3);
  PushByHand(ObjectNamed(script, "ball"), {.begin_s = 1, .end_s = 2},
             MakeTranslation(0.05, 0.02, 0) * script.scene.objects[8].X_WO,
             {.from_W = {0.4, -0.5, 1.5}}, script);
  script.robots = {Slider()};
  SequenceScript moving = script;
  moving.sensors[0].mount = std::vector<TimedPose>{{.X_WB = KitchenCamera().X_WC}};
  for (const SensorModel model :
       {SensorModel::kKinect, SensorModel::kRealSense, SensorModel::kTimeOfFlight}) {
    script.sensors[0].noise.model = moving.sensors[0].noise.model = model;
    const SequenceRenderer fixed_renderer(script);
    const SequenceRenderer moving_renderer(moving);
    for (const int k : {0, 45, 80}) {
      ExpectSameFrames(fixed_renderer.Render(0, k), moving_renderer.Render(0, k));
    }
  }
}

TEST(Sequence, MovesAPushedObjectOnAStraightLineAndLeavesItExactlyThere) {
  SequenceScript script = Kitchen(4);
  const std::size_t mug = ObjectNamed(script, "mug");
  const Pose start = script.scene.objects[mug].X_WO;
  const Pose goal = MakeTranslation(0.06, -0.02, 0) * start;
  script.events = {{.object = mug, .begin_s = 1, .end_s = 2, .what = MoveEvent{.X_WO = goal}}};
  const ObjectState before = ObjectStateAt(script, mug, 0.9);
  const ObjectState half = ObjectStateAt(script, mug, 1.5);
  const ObjectState after = ObjectStateAt(script, mug, 2);
  EXPECT_EQ(before.X_WO.matrix(), start.matrix());
  EXPECT_FALSE(before.is_moving);
  const Vector3 middle = start.translation() + Vector3(0.03, -0.01, 0);
  EXPECT_LT((half.X_WO.translation() - middle).norm(), kRounding_m);
  EXPECT_TRUE(half.is_moving);
  EXPECT_EQ(after.X_WO.matrix(), goal.matrix());
  EXPECT_EQ(ObjectStateAt(script, mug, 3.7).X_WO.matrix(), goal.matrix());
  EXPECT_FALSE(after.is_moving);
}

// The distance of a measured point from the nearest part of the object at its true place.
double DistanceFrom_m(const SimulatedObject& object, const Pose& X_WO, const Vector3& p_W) {
  double nearest_m = 1e9;
  for (const Placed<>& part : object.parts) {
    const Vector3 p_S = (X_WO * part.X_FS).inverse() * p_W;
    nearest_m = std::min(nearest_m, std::abs(SignedDistance_m(part.shape, p_S)));
  }
  return nearest_m;
}

TEST(Sequence, MeasuresAMovingObjectWhereTheTruthSaysItIs) {
  SequenceScript script = Kitchen(4);
  const std::size_t soup = ObjectNamed(script, "soup");
  const Pose goal = MakeTranslation(-0.1, 0.05, 0) * script.scene.objects[soup].X_WO;
  script.events = {{.object = soup, .begin_s = 1, .end_s = 2, .what = MoveEvent{.X_WO = goal}}};
  const SequenceRenderer renderer(script);
  for (const int k : {0, 37, 52, 90}) {
    const SequenceFrame frame = renderer.Render(0, k);
    ASSERT_GT(frame.objects[soup].pixel_count, 200);
    std::size_t far = 0;
    std::int64_t labelled = 0;
    for (int v = 0; v < 240; ++v) {
      for (int u = 0; u < 320; ++u) {
        const std::size_t i = static_cast<std::size_t>(v) * 320 + u;
        if (frame.depth.object[i] != static_cast<std::int32_t>(soup)) continue;
        ++labelled;
        const Vector3 p_C = frame.depth.depth_m[i] * RayDirection(frame.camera, u, v);
        far += DistanceFrom_m(script.scene.objects[soup], frame.objects[soup].state.X_WO,
                              frame.camera.X_WC * p_C) > 0.008;
      }
    }
    EXPECT_EQ(labelled, frame.objects[soup].pixel_count);
    // Axial errors are 2.5 mm with the warp, so that 8 mm are three sigma; at the outline a shift
    // of a pixel, 3.4 mm here, extends the surface along its tangent.
    EXPECT_LT(static_cast<double>(far), 0.03 * static_cast<double>(labelled)) << k;
  }
}

TEST(Sequence, TakesAnObjectAwayWithAHandAndBringsItBack) {
  SequenceScript script = Kitchen(8);
  const std::size_t tea = ObjectNamed(script, "tea");
  const Pose place = script.scene.objects[tea].X_WO;
  TakeByHand(tea, 2, {.from_W = {0.5, -0.7, 1.5}}, script);
  PutByHand(tea, 6, place, {.name = "hand_2", .from_W = {0.5, -0.7, 1.5}}, script);
  const SequenceRenderer renderer(script);
  const SequenceFrame before = renderer.Render(0, 0);
  EXPECT_EQ(before.hand_pixel_count, 0);
  EXPECT_EQ(before.objects[tea].visible_share, 1);
  EXPECT_EQ(before.objects[tea].state.X_WO.matrix(), place.matrix());
  const SequenceFrame grasped = renderer.Render(0, 61);  // in the hold between grasp and lift
  EXPECT_GT(grasped.hand_pixel_count, 200);
  EXPECT_LT(grasped.objects[tea].visible_share, 0.95);
  EXPECT_FALSE(grasped.objects[tea].state.is_moving);
  const SequenceFrame lifted = renderer.Render(0, 75);
  ASSERT_TRUE(lifted.objects[tea].state.carrier.has_value());
  EXPECT_EQ(*lifted.objects[tea].state.carrier, Carrier(HandRef{.hand = 0}));
  EXPECT_GT(lifted.objects[tea].state.X_WO.translation().z(), place.translation().z() + 0.1);
  const SequenceFrame gone = renderer.Render(0, 120);
  EXPECT_FALSE(gone.objects[tea].state.is_present);
  EXPECT_EQ(gone.objects[tea].pixel_count, 0);
  EXPECT_EQ(gone.objects[tea].visible_share, 0);
  EXPECT_EQ(gone.hand_pixel_count, 0);
  const SequenceFrame back = renderer.Render(0, 230);
  EXPECT_TRUE(back.objects[tea].state.is_present);
  EXPECT_FALSE(back.objects[tea].state.is_moving);
  EXPECT_LT((back.objects[tea].state.X_WO.matrix() - place.matrix()).norm(), kRounding_m);
  EXPECT_EQ(back.objects[tea].state.X_WO.matrix(),
            renderer.Render(0, 239).objects[tea].state.X_WO.matrix());
}

TEST(Sequence, KeepsACarriedObjectAtItsPlaceInTheFrameOfTheLink) {
  SequenceScript script = Kitchen(6);
  script.robots = {Slider()};
  const std::size_t cup = ObjectNamed(script, "cup");
  script.events = {{.object = cup,
                    .begin_s = 1,
                    .end_s = 4,
                    .what = CarryEvent{.carrier = LinkRef{.robot = 0, .link = 1}}}};
  const Vector3 start = script.scene.objects[cup].X_WO.translation();
  EXPECT_LT((ObjectStateAt(script, cup, 3).X_WO.translation() - start - Vector3(0, 0.2, 0)).norm(),
            kRounding_m);
  EXPECT_LT((ObjectStateAt(script, cup, 5).X_WO.translation() - start - Vector3(0, 0.3, 0)).norm(),
            kRounding_m);
  EXPECT_TRUE(ObjectStateAt(script, cup, 3.99).carrier.has_value());
  EXPECT_FALSE(ObjectStateAt(script, cup, 4).carrier.has_value());
}

TEST(Sequence, CountsThePixelsOfRobotsAndMovesASensorWithItsLink) {
  SequenceScript script = Kitchen(2);
  script.robots = {Slider()};
  script.sensors.push_back(script.sensors[0]);
  script.sensors[1].name = "wrist";
  const Pose X_LC = MakePose({0, 0, 0.2}, Quaternion(0, 1, 0, 0));  // looks down
  script.sensors[1].mount = MountedOnLink{.link = {.robot = 0, .link = 1}, .X_LC = X_LC};
  const SequenceRenderer renderer(script);
  const SequenceFrame front = renderer.Render(0, 30);
  std::int64_t robot_pixels = 0;
  for (const std::int32_t object : front.depth.object) {
    robot_pixels += object >= 0 && renderer.bodies()[static_cast<std::size_t>(object)].kind ==
                                       SequenceBody::Kind::kRobot;
  }
  EXPECT_GT(robot_pixels, 500);
  EXPECT_EQ(front.robot_pixel_count, robot_pixels);
  EXPECT_DOUBLE_EQ(front.joint_values[0][0], 0.1);  // after a second
  const Pose expected = MakeTranslation(0.5, -0.3, 1.1) * X_LC;
  EXPECT_LT((renderer.Render(1, 30).camera.X_WC.matrix() - expected.matrix()).norm(), kRounding_m);
}

TEST(Sequence, StampsFramesByTheClockOfTheSensor) {
  SequenceScript script = Kitchen(1);
  script.start_stamp_s = 500;
  script.sensors[0].rate_hz = 10;
  script.sensors[0].start_s = 0.05;
  script.sensors[0].clock_offset_s = 0.004;
  EXPECT_EQ(FrameCount(script, script.sensors[0]), 10);
  const SequenceFrame frame = SequenceRenderer(script).Render(0, 2);
  EXPECT_DOUBLE_EQ(frame.time_s, 0.25);
  EXPECT_DOUBLE_EQ(frame.stamp_s, 500.254);
}

TEST(Sequence, DeliversFramesLateTwiceSwappedOrNever) {
  SequenceScript script = Kitchen(1);
  SequenceSensor& sensor = script.sensors[0];
  sensor.rate_hz = 10;
  sensor.latency_s = 0.02;
  sensor.lost.frames = {1};
  sensor.doubled.frames = {3};
  sensor.late.frames = {5};
  sensor.late_by_s = 0.25;
  sensor.swapped.frames = {8};
  std::vector<int> order;
  double last_s = 0;
  for (const FrameDelivery& delivery : FrameDeliveries(script, 0)) {
    order.push_back(delivery.frame);
    EXPECT_GE(delivery.delivery_s, last_s);
    EXPECT_DOUBLE_EQ(delivery.stamp_s, 1000 + 0.1 * delivery.frame);
    EXPECT_GE(delivery.delivery_s, delivery.stamp_s + 0.02 - 1e-9);
    last_s = delivery.delivery_s;
  }
  EXPECT_EQ(order, (std::vector<int>{0, 2, 3, 3, 4, 6, 7, 5, 9, 8}));
}

TEST(Sequence, DrawsTheFramesThatAreLostByTheirRate) {
  SequenceScript script = Kitchen(100);
  script.sensors[0].lost.rate = 0.2;
  const auto deliveries = FrameDeliveries(script, 0);
  // 3000 frames, a binomial of sigma 22.
  EXPECT_NEAR(static_cast<double>(deliveries.size()), 2400, 100);
  const auto again = FrameDeliveries(script, 0);
  ASSERT_EQ(again.size(), deliveries.size());
  script.seed = 2;
  std::set<int> first, other;
  for (const auto& delivery : deliveries) first.insert(delivery.frame);
  for (const auto& delivery : FrameDeliveries(script, 0)) other.insert(delivery.frame);
  EXPECT_NE(first, other);
}

TEST(Sequence, LeavesOutAndDelaysJointStates) {
  SequenceScript script = Kitchen(1);
  SimulatedRobot robot = Slider();
  robot.states = {.rate_hz = 100,
                  .clock_offset_s = 0.001,
                  .latency_s = 0.005,
                  .missing = {{.begin_s = 0.4, .end_s = 0.6}},
                  .late = {{.during = {.begin_s = 0.795, .end_s = 0.895}, .by_s = 0.2}}};
  script.robots = {robot};
  const auto states = JointStateDeliveries(script, 0);
  // 111 states from -0.1 to 1 s, of which 20 are missing.
  EXPECT_EQ(states.size(), 91U);
  EXPECT_LT(states.front().stamp_s, 1000);
  int late = 0;
  for (const JointStateDelivery& state : states) {
    const double time_s = state.stamp_s - 1000.001;
    EXPECT_FALSE(time_s > 0.401 && time_s < 0.589) << time_s;
    EXPECT_NEAR(state.values[0], 0.1 * std::max(0.0, time_s), 1e-9);
    late += state.delivery_s - state.stamp_s > 0.1;
  }
  EXPECT_EQ(late, 10);
}

TEST(Sequence, HasAHandOfTheSizeOfAHand) {
  const SimulatedObject hand = MakeHand(0.06);
  const Aabb bounds = BoundsInWorld(hand);
  EXPECT_NEAR(bounds.sizes().z(), 0.51, 0.03);  // hand and forearm
  EXPECT_GT(bounds.sizes().x(), 0.075);
  EXPECT_LT(bounds.sizes().x(), 0.1);
  EXPECT_NEAR(bounds.max().z(), 0.008, 0.005);  // the tips, at the frame's origin
}

}  // namespace
}  // namespace cwm::perception
