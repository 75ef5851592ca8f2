// A simulated depth camera over a kitchen counter: what its world says, and that it says the same
// again. This file is longer than 500 lines: all of its tests run one kitchen.
#include "server/core/live/live_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <optional>

#include "perception/interpret_scene.h"
#include "perception/simulation/hand.h"
#include "perception/simulation/scenes.h"
#include "perception/simulation/sequence_renderer.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::ObjectKind;
using perception::ObjectEvent;
using perception::SequenceScript;
using perception::SimulatedObject;

// The demo's kitchen, seen at half the resolution of the demo's camera.
SequenceScript Kitchen(double duration_s) {
  SequenceScript script;
  script.scene = perception::KitchenCounter();
  script.duration_s = duration_s;
  script.start_stamp_s = 1'700'000'000;
  perception::SequenceSensor sensor;
  sensor.name = "head";
  sensor.camera = perception::KitchenCamera();
  sensor.camera.width = 320;
  sensor.camera.height = 240;
  sensor.camera.focal_px /= 2;
  sensor.camera.center_x_px = 159.5;
  sensor.camera.center_y_px = 119.5;
  sensor.mount = sensor.camera.X_WC;
  sensor.rate_hz = 15;
  script.sensors.push_back(sensor);
  return script;
}

perception::DepthCamera CameraOf(const perception::PinholeCamera& camera) {
  return {.pinhole = {.focal_u_px = camera.focal_px,
                      .focal_v_px = camera.focal_px,
                      .center_u_px = camera.center_x_px,
                      .center_v_px = camera.center_y_px},
          .width = camera.width,
          .height = camera.height};
}

LiveFrame FrameOf(const perception::SequenceFrame& rendered) {
  LiveFrame frame;
  frame.stamp = perception::Stamp(std::chrono::duration_cast<perception::Stamp::duration>(
      std::chrono::duration<double>(rendered.stamp_s)));
  frame.camera = CameraOf(rendered.camera);
  auto image = std::make_shared<perception::DepthImage>();
  image->width = rendered.depth.width;
  image->height = rendered.depth.height;
  image->depth_m = rendered.depth.depth_m;
  frame.image = std::move(image);
  frame.received = frame.begun = frame.decoded = Clock::now();
  return frame;
}

// A world that a sensor streams into. Regions are interpreted between frames, so that the result
// does not depend on the machine.
class LiveRun {
 public:
  explicit LiveRun(const SequenceScript& script) : renderer_(script) {
    SensorCalibration calibration{.sensor = "head"};
    calibration.X_WC = CameraAt(script, script.sensors[0], 0).X_WC;
    auto opened = live_->Open(calibration, [this](const absl::Status& why) { ended_ = why; });
    EXPECT_TRUE(opened.ok()) << opened.status();
    stream_ = *std::move(opened);
  }

  LiveFrame Rendered(int index) const { return FrameOf(renderer_.Render(0, index)); }
  FrameOutcome Process(const LiveFrame& frame) {
    auto outcome = stream_->Process(frame);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    if (!holds_) Interpret();
    return outcome.ok() ? *std::move(outcome) : FrameOutcome();
  }
  // From now on regions wait for Interpret.
  void Hold() { holds_ = true; }
  void Interpret() {
    while (!beside_.empty()) {
      const std::function<void()> task = std::move(beside_.front());
      beside_.pop_front();
      task();
      ++interpreted_;
    }
  }
  std::size_t waiting() const { return beside_.size(); }
  FrameOutcome Process(int index) { return Process(Rendered(index)); }
  void CloseStream() { stream_.reset(); }
  SensorStream& stream() { return *stream_; }

  SnapshotPtr snapshot() const { return world_->Snapshot(); }
  std::int64_t revision() const { return snapshot()->revision().value; }
  int interpreted() const { return interpreted_; }
  const std::shared_ptr<World>& world() const { return world_; }
  LiveWorld& live() { return *live_; }
  std::optional<absl::Status> ended() const { return ended_; }

  int CountOf(ObjectKind kind) const {
    int count = 0;
    for (const auto& object : snapshot()->objects()) count += object->kind == kind ? 1 : 0;
    return count;
  }
  // The object whose bounds hold the point; nullptr: none.
  collision::WorldObjectPtr ObjectAt(const Vector3& p_W) const {
    for (const auto& object : snapshot()->objects()) {
      if (object->kind == ObjectKind::kObject && object->bounds_W.contains(p_W)) return object;
    }
    return nullptr;
  }

 private:
  const perception::SequenceRenderer renderer_;
  std::deque<std::function<void()>> beside_;
  const std::shared_ptr<World> world_ = std::make_shared<World>("w", "uid", Retention{});
  const std::shared_ptr<LiveWorld> live_ = std::make_shared<LiveWorld>(
      world_, LiveServices{.interpret = perception::InterpretScene,
                           .run_beside = [this](std::function<void()> task) {
                             beside_.push_back(std::move(task));
                             return true;
                           }});
  std::optional<absl::Status> ended_;
  std::unique_ptr<SensorStream> stream_;
  int interpreted_ = 0;
  bool holds_ = false;
};

// Everything that a client can read of a world's geometry, bit by bit.
std::string BytesOf(const collision::WorldSnapshot& snapshot) {
  std::string bytes = std::to_string(snapshot.revision().value);
  const auto add = [&bytes](const auto& numbers, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(numbers), count * sizeof(*numbers));
  };
  for (const auto& object : snapshot.objects()) {
    bytes += object->Uid() + std::string(NameOf(object->kind));
    add(object->X_WO.data(), 16);
    add(object->bounds_W.min().data(), 3);
    add(object->bounds_W.max().data(), 3);
    for (const ShapePart& part : object->model().shapes) add(part.X_OS.data(), 16);
  }
  return bytes;
}

TEST(LiveWorldTest, AStaticSceneIsInterpretedOnceAndThenMakesNoRevision) {
  LiveRun run(Kitchen(3));
  for (int k = 0; k < 10; ++k) run.Process(k);
  EXPECT_EQ(run.interpreted(), 1);
  const std::int64_t revision = run.revision();
  EXPECT_GT(run.CountOf(ObjectKind::kObject), 3);
  for (int k = 10; k < 45; ++k) {
    const FrameOutcome outcome = run.Process(k);
    EXPECT_EQ(outcome.fate, FrameFate::kProcessed);
    EXPECT_EQ(outcome.revision.value, revision) << "frame " << k;
  }
  EXPECT_EQ(run.interpreted(), 1);
}

TEST(LiveWorldTest, FramesThatCameLateOrTwiceChangeNothing) {
  SequenceScript script = Kitchen(1.5);
  LiveRun good(script);
  LiveRun hindered(script);
  for (int k = 0; k < 20; ++k) {
    if (k % 5 == 3) continue;  // lost
    good.Process(k);
    hindered.Process(k);
    EXPECT_EQ(hindered.Process(k).reason, "STALE_FRAME");
    if (k >= 2) {
      EXPECT_EQ(hindered.Process(k - 2).reason, "STALE_FRAME");
    }
  }
  EXPECT_EQ(BytesOf(*good.snapshot()), BytesOf(*hindered.snapshot()));
}

TEST(LiveWorldTest, ASensorThatIsGoneLeavesNoMoversAndNoFacts) {
  SequenceScript script = Kitchen(2);
  perception::SimulatedHand hand;
  hand.name = "hand";
  hand.shape = perception::MakeHand(0.06);
  // From above into the middle of the view, 0.15 m before the counter, the fingers down.
  const Vector3 p_WH = script.sensors[0].camera.X_WC * Vector3(0, 0, 0.75);
  const Pose X_WH = Eigen::Translation3d(p_WH) * Eigen::AngleAxisd(3.14159265, Vector3::UnitX());
  hand.waypoints = {{1.0, MakeTranslation(0, 0, 0.5) * X_WH}, {1.8, X_WH}, {2.0, X_WH}};
  script.hands.push_back(hand);
  LiveRun run(script);
  int most_movers = 0;
  for (int k = 0; k < 30; ++k) {
    run.Process(k);
    most_movers = std::max(most_movers, run.CountOf(ObjectKind::kMover));
  }
  EXPECT_GT(most_movers, 0);
  bool has_facts = false;
  for (const auto& object : run.snapshot()->objects()) {
    has_facts |= run.world()->observations().Get(object->name).facts.has_value();
  }
  EXPECT_TRUE(has_facts);
  run.CloseStream();
  run.live().ForgetGone(Clock::now() + std::chrono::seconds(1));
  EXPECT_EQ(run.live().Sensors().size(), 1U);
  run.live().ForgetGone(Clock::now() + std::chrono::seconds(3));
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
  for (const auto& object : run.snapshot()->objects()) {
    EXPECT_FALSE(run.world()->observations().Get(object->name).facts.has_value());
  }
}

// The object of the scene whose name begins so.
std::size_t ObjectNamed(const SequenceScript& script, const std::string& name) {
  const auto& objects = script.scene.objects;
  const auto found = std::ranges::find_if(
      objects, [&](const perception::SimulatedObject& o) { return o.name.starts_with(name); });
  EXPECT_NE(found, objects.end()) << name;
  return static_cast<std::size_t>(found - objects.begin());
}

TEST(LiveWorldTest, AThingThatSlidesKeepsItsNameAndEndsWhereItIs) {
  SequenceScript script = Kitchen(4);
  const std::size_t tea = ObjectNamed(script, "tea");
  const Aabb before_W = BoundsInWorld(script.scene.objects[tea]);
  const Vector3 shift(0, 0.1, 0);
  script.events.push_back({.object = tea,
                           .begin_s = 1.5,
                           .end_s = 2.2,
                           .what = perception::MoveEvent{Eigen::Translation3d(shift) *
                                                         script.scene.objects[tea].X_WO}});
  LiveRun run(script);
  for (int k = 0; k < 20; ++k) run.Process(k);
  const collision::WorldObjectPtr before = run.ObjectAt(before_W.center());
  ASSERT_NE(before, nullptr);
  bool was_moving = false;
  for (int k = 20; k < 58; ++k) {
    run.Process(k);
    const auto facts = run.world()->observations().Get(before->name).facts;
    was_moving |= facts.has_value() && facts->motion == SensorFacts::Motion::kMoving;
  }
  EXPECT_TRUE(was_moving);
  const collision::WorldObjectPtr after = run.ObjectAt(before_W.center() + shift);
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->name, before->name);
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
  const Vector3 moved = after->bounds_W.center() - before->bounds_W.center();
  constexpr double kTolerance_m = 0.006;  // of two views by a sensor with 1.5 mm of warp
  EXPECT_NEAR((moved - shift).norm(), 0, kTolerance_m) << moved.transpose();
}

TEST(LiveWorldTest, AThingThatMovesFarFromFrameToFrameIsFollowed) {
  // Up to 50 mm from one frame of a slow sensor to the next, from rest and back to it.
  SequenceScript script = Kitchen(5);
  script.sensors[0].rate_hz = 10;
  const std::size_t tea = ObjectNamed(script, "tea");
  const Aabb before_W = BoundsInWorld(script.scene.objects[tea]);
  Pose X_WO = script.scene.objects[tea].X_WO;
  const std::vector<Vector3> steps = {{0, 0.015, 0.02}, {0, 0.03, 0.03},  {0, 0.05, 0},
                                      {0, 0.05, 0},     {0, 0.02, -0.03}, {0, 0.01, -0.02}};
  double time_s = 2;
  for (const Vector3& step : steps) {
    X_WO.translation() += step;
    script.events.push_back({.object = tea,
                             .begin_s = time_s,
                             .end_s = time_s + 0.1,
                             .what = perception::MoveEvent{X_WO}});
    time_s += 0.1;
  }
  LiveRun run(script);
  for (int k = 0; k < 18; ++k) run.Process(k);
  const collision::WorldObjectPtr before = run.ObjectAt(before_W.center());
  ASSERT_NE(before, nullptr);
  for (int k = 18; k < 48; ++k) {
    const FrameOutcome outcome = run.Process(k);
    EXPECT_TRUE(outcome.changes.removed.empty()) << "frame " << k;
    EXPECT_TRUE(outcome.changes.added.empty()) << "frame " << k;
  }
  const Vector3 shift(0, 0.175, 0);
  const collision::WorldObjectPtr after = run.ObjectAt(before_W.center() + shift);
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after->name, before->name);
  const Vector3 moved = after->bounds_W.center() - before->bounds_W.center();
  EXPECT_NEAR((moved - shift).norm(), 0, 0.008) << moved.transpose();
}

TEST(LiveWorldTest, AThingThatLeftWhileItWasInterpretedIsNotAdded) {
  SequenceScript script = Kitchen(4);
  const std::size_t tea = ObjectNamed(script, "tea");
  script.events.push_back({.object = tea,
                           .begin_s = 1.2,
                           .end_s = 1.2,
                           .what = perception::AppearEvent{script.scene.objects[tea].X_WO}});
  script.events.push_back(
      {.object = tea, .begin_s = 2.2, .end_s = 2.2, .what = perception::VanishEvent{}});
  LiveRun run(script);
  for (int k = 0; k < 18; ++k) run.Process(k);
  ASSERT_EQ(run.interpreted(), 1);
  const int objects = run.CountOf(ObjectKind::kObject);
  run.Hold();
  for (int k = 18; k < 40; ++k) run.Process(k);
  EXPECT_EQ(run.waiting(), 1U);
  run.Interpret();
  for (int k = 40; k < 58; ++k) {
    const FrameOutcome outcome = run.Process(k);
    EXPECT_TRUE(outcome.changes.added.empty()) << "frame " << k;
    EXPECT_TRUE(outcome.changes.removed.empty()) << "frame " << k;
  }
  EXPECT_EQ(run.CountOf(ObjectKind::kObject), objects);
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
}

TEST(LiveWorldTest, AnArmThatReachesIntoTheViewIsNoThing) {
  SequenceScript script = Kitchen(6);
  const Aabb tea_W = BoundsInWorld(script.scene.objects[ObjectNamed(script, "tea")]);
  perception::SimulatedHand arm;
  arm.name = "arm";
  arm.shape = perception::MakeHand(0.06);
  arm.shape.parts.push_back({.X_FS = MakeTranslation(0, 0, -0.7), .shape = Capsule{0.045, 0.6}});
  // From the side over the border of the view, its fingers at the tea for a second.
  const Vector3 tips = tea_W.center() + Vector3(0, 0, 0.02);
  const auto at = [&](const Vector3& tips_W) {
    const Vector3 to_tips(0.1, -0.4, -0.2);
    return MakePose(tips_W, Quaternion::FromTwoVectors(Vector3::UnitZ(), to_tips));
  };
  arm.waypoints = {{1.5, at(tips + Vector3(0, 0.6, 0.3))},
                   {2.0, at(tips)},
                   {3.2, at(tips)},
                   {3.7, at(tips + Vector3(0, 0.6, 0.3))}};
  script.hands.push_back(arm);
  LiveRun run(script);
  for (int k = 0; k < 20; ++k) run.Process(k);
  const std::int64_t objects = run.CountOf(ObjectKind::kObject);
  for (int k = 20; k < 88; ++k) {
    const FrameOutcome outcome = run.Process(k);
    EXPECT_TRUE(outcome.changes.added.empty()) << "frame " << k;
    EXPECT_TRUE(outcome.changes.replaced.empty()) << "frame " << k;
    EXPECT_TRUE(outcome.changes.removed.empty()) << "frame " << k;
  }
  EXPECT_EQ(run.CountOf(ObjectKind::kObject), objects);
}

TEST(LiveWorldTest, AThingPutAgainstAnotherIsAThingOfItsOwn) {
  SequenceScript script = Kitchen(4);
  const std::size_t tea = ObjectNamed(script, "tea");
  const Aabb tea_W = BoundsInWorld(script.scene.objects[tea]);
  // Two millimetres beside it.
  const Vector3 size(0.08, 0.05, 0.08);
  const Vector3 place(tea_W.center().x(), tea_W.max().y() + 0.002 + size.y() / 2,
                      tea_W.min().z() + size.z() / 2);
  script.scene.objects.push_back({.name = "carton", .parts = {{.shape = Box{size}}}});
  script.events.push_back(
      {.object = script.scene.objects.size() - 1,
       .begin_s = 1.5,
       .end_s = 1.5,
       .what = perception::AppearEvent{MakeTranslation(place.x(), place.y(), place.z())}});
  LiveRun run(script);
  for (int k = 0; k < 20; ++k) run.Process(k);
  const collision::WorldObjectPtr before = run.ObjectAt(tea_W.center());
  ASSERT_NE(before, nullptr);
  const int objects = run.CountOf(ObjectKind::kObject);
  for (int k = 20; k < 58; ++k) run.Process(k);
  const collision::WorldObjectPtr after = run.ObjectAt(tea_W.center());
  ASSERT_NE(after, nullptr);
  EXPECT_EQ(after, before) << "what stood there has not changed";
  const collision::WorldObjectPtr carton = run.ObjectAt(place);
  ASSERT_NE(carton, nullptr);
  EXPECT_NE(carton->name, before->name);
  EXPECT_EQ(run.CountOf(ObjectKind::kObject), objects + 1);
}

TEST(LiveWorldTest, WhatStaysIsAskedForAgainThoughSomethingBesideItLeft) {
  // A thing is put and a hand rests at it. While both are interpreted the hand leaves.
  SequenceScript script = Kitchen(5);
  const std::size_t tea = ObjectNamed(script, "tea");
  const SimulatedObject thing = script.scene.objects[tea];
  const Aabb tea_W = BoundsInWorld(thing);
  script.scene.objects.push_back({.name = "hand", .parts = {{.shape = Sphere{0.05}}}});
  const std::size_t hand = script.scene.objects.size() - 1;
  const Vector3 top(tea_W.center().x(), tea_W.center().y(), tea_W.max().z() + 0.045);
  const auto add = [&](std::size_t object, double time_s, decltype(ObjectEvent::what) what) {
    script.events.push_back(
        {.object = object, .begin_s = time_s, .end_s = time_s, .what = std::move(what)});
  };
  add(tea, 1.2, perception::AppearEvent{thing.X_WO});
  add(hand, 1.2, perception::AppearEvent{MakeTranslation(top.x(), top.y(), top.z())});
  add(hand, 2.2, perception::VanishEvent{});
  LiveRun run(script);
  for (int k = 0; k < 18; ++k) run.Process(k);
  EXPECT_EQ(run.ObjectAt(tea_W.center()), nullptr);
  run.Hold();
  for (int k = 18; k < 40; ++k) run.Process(k);
  EXPECT_EQ(run.waiting(), 1U);
  for (int k = 40; k < 70; ++k) {
    run.Interpret();
    run.Process(k);
  }
  const collision::WorldObjectPtr after = run.ObjectAt(tea_W.center());
  ASSERT_NE(after, nullptr);
  EXPECT_LT(after->bounds_W.max().z(), tea_W.max().z() + 0.01);
}

TEST(LiveWorldTest, WhatIsTooSmallForAnObjectStaysAMoverWhileItIsThere) {
  SequenceScript script = Kitchen(6);
  const Aabb tea_W = BoundsInWorld(script.scene.objects[ObjectNamed(script, "tea")]);
  const Vector3 size(0.02, 0.02, 0.03);
  const Vector3 place(tea_W.center().x(), tea_W.max().y() + 0.1, tea_W.min().z() + size.z() / 2);
  script.scene.objects.push_back({.name = "peg", .parts = {{.shape = Box{size}}}});
  const std::size_t peg = script.scene.objects.size() - 1;
  script.events.push_back(
      {.object = peg,
       .begin_s = 1.5,
       .end_s = 1.5,
       .what = perception::AppearEvent{MakeTranslation(place.x(), place.y(), place.z())}});
  script.events.push_back(
      {.object = peg, .begin_s = 5, .end_s = 5, .what = perception::VanishEvent{}});
  LiveRun run(script);
  for (int k = 0; k < 20; ++k) run.Process(k);
  const int objects = run.CountOf(ObjectKind::kObject);
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
  for (int k = 20; k < 36; ++k) run.Process(k);
  const int interpreted = run.interpreted();
  std::int64_t revision = 0;
  for (int k = 36; k < 75; ++k) {
    run.Process(k);
    EXPECT_EQ(run.CountOf(ObjectKind::kMover), 1) << "frame " << k;
    if (k == 50) revision = run.revision();
  }
  EXPECT_EQ(run.interpreted(), interpreted) << "it is asked for once";
  EXPECT_EQ(run.revision(), revision) << "it rests";
  EXPECT_EQ(run.CountOf(ObjectKind::kObject), objects);
  for (int k = 75; k < 78; ++k) run.Process(k);
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
}

TEST(LiveWorldTest, WhatHangsInTheAirIsAMoverForTenSeconds) {
  SequenceScript script = Kitchen(15);
  const Aabb tea_W = BoundsInWorld(script.scene.objects[ObjectNamed(script, "tea")]);
  script.scene.objects.push_back({.name = "fist", .parts = {{.shape = Sphere{0.05}}}});
  const Vector3 place = tea_W.center() + Vector3(0, 0.15, 0.25);
  script.events.push_back(
      {.object = script.scene.objects.size() - 1,
       .begin_s = 1.5,
       .end_s = 1.5,
       .what = perception::AppearEvent{MakeTranslation(place.x(), place.y(), place.z())}});
  LiveRun run(script);
  for (int k = 0; k < 24; ++k) run.Process(k);
  for (int k = 24; k < 165; ++k) {
    EXPECT_TRUE(run.Process(k).changes.added.empty()) << "frame " << k;
    EXPECT_EQ(run.CountOf(ObjectKind::kMover), 1) << "frame " << k;
  }
  const int residuals = run.CountOf(ObjectKind::kResidual);
  for (int k = 165; k < 220; ++k) run.Process(k);
  EXPECT_EQ(run.CountOf(ObjectKind::kResidual), residuals + 1) << "that nothing bears";
  EXPECT_EQ(run.CountOf(ObjectKind::kMover), 0);
}

TEST(LiveWorldTest, SensorsThatAreGoneMakeRoomForOthers) {
  const auto world = std::make_shared<World>("w", "uid", Retention{});
  const auto live = std::make_shared<LiveWorld>(world, LiveServices{});
  std::vector<std::unique_ptr<SensorStream>> streams;
  for (std::size_t s = 0; s < LiveWorld::kMaxSensors; ++s) {
    auto stream = live->Open({.sensor = "sensor_" + std::to_string(s)}, {});
    ASSERT_TRUE(stream.ok()) << stream.status();
    streams.push_back(*std::move(stream));
  }
  EXPECT_EQ(DetailsOf(live->Open({.sensor = "more"}, {}).status()).reason, "TOO_MANY_SENSORS");
  EXPECT_TRUE(live->Open({.sensor = "sensor_3"}, {}).ok());  // it is known
  streams.erase(streams.begin() + 7);
  EXPECT_TRUE(live->Open({.sensor = "more"}, {}).ok());
  EXPECT_FALSE(live->Has("sensor_3") && live->Has("sensor_7"));
}

TEST(LiveWorldTest, TheViewOfASensorIsPaidForUntilItIsForgotten) {
  constexpr std::int64_t kView_bytes = 1'000'000;
  const auto budget = MemoryBudget::Make(std::int64_t{1} << 30);
  const auto charged = [&] {
    MemoryCharge charge = MemoryCharge::Empty(budget, MemoryBudget::Client({}));
    EXPECT_TRUE(charge.Resize(kView_bytes).ok());
    return charge;
  };
  LiveRun run(Kitchen(1));
  run.stream().Hold(charged());
  run.Process(0);
  run.stream().Hold(charged());  // as a later stream of the sensor does
  EXPECT_EQ(budget->client_bytes(), kView_bytes);
  run.CloseStream();
  EXPECT_FALSE(run.live().ForgetGone(Clock::now() + std::chrono::seconds(3)));
  EXPECT_EQ(budget->client_bytes(), kView_bytes) << "it may come back, and finds what it learnt";
  EXPECT_TRUE(run.live().ForgetGone(Clock::now() + LiveWorld::kKeepTime));
  EXPECT_EQ(budget->client_bytes(), 0);
  EXPECT_FALSE(run.live().ForgetGone(Clock::now() + LiveWorld::kKeepTime)) << "nothing is left";
}

TEST(LiveWorldTest, TheWorldsEndEndsItsStreams) {
  LiveRun run(Kitchen(1));
  run.Process(0);
  run.live().End(MakeError(absl::StatusCode::kNotFound, "gone", {.reason = "WORLD_DELETED"}));
  ASSERT_TRUE(run.ended().has_value());
  EXPECT_EQ(DetailsOf(*run.ended()).reason, "WORLD_DELETED");
  EXPECT_FALSE(run.live().Open({.sensor = "head"}, {}).ok());
}

}  // namespace
}  // namespace cwm::server
