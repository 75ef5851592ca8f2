// The tracker on simulated sequences: what rests, moves, is taken, put and hidden.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "perception/simulation/furniture.h"
#include "perception/simulation/hand.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/scenes.h"
#include "tests/perception/live/tracked_sequence.h"

namespace cwm::perception {
namespace {

using Kind = TrackChange::Kind;

// A table with things before a still Kinect.
SequenceScript Table(double duration_s, std::uint64_t seed = 5) {
  SequenceScript script;
  script.scene = RandomTable(seed, 6);
  script.duration_s = duration_s;
  script.seed = seed;
  SequenceSensor sensor;
  sensor.name = "head";
  sensor.camera = KitchenCamera();
  sensor.mount = KitchenCamera().X_WC;
  script.sensors.push_back(sensor);
  return script;
}

int CountOf(const std::vector<TrackedFrame>& frames, Kind kind) {
  int count = 0;
  for (const TrackedFrame& frame : frames) {
    count += static_cast<int>(std::ranges::count(frame.changes, kind, &TrackChange::kind));
  }
  return count;
}

// The first frame with a change of the kind about the body; -1: none.
int FirstOf(const std::vector<TrackedFrame>& frames, Kind kind, BodyId body = kNoBody) {
  for (const TrackedFrame& frame : frames) {
    for (const TrackChange& change : frame.changes) {
      if (change.kind == kind && (body == kNoBody || change.body == body)) return frame.frame;
    }
  }
  return -1;
}

Pose Beside(const SequenceScript& script, std::size_t object, const Vector3& shift_W) {
  Pose X_WO = script.scene.objects[object].X_WO;
  X_WO.translation() += shift_W;
  return X_WO;
}

TEST(TrackerOnSequences, SaysNothingWhileNothingChanges) {
  for (const std::uint64_t seed : {5U, 6U, 7U}) {
    TrackedSequence sequence(Table(3, seed));
    const std::vector<TrackedFrame> frames = sequence.Run();
    for (const TrackedFrame& frame : frames) {
      EXPECT_TRUE(frame.changes.empty()) << "seed " << seed << ", frame " << frame.frame;
    }
    const TrackedFacts facts = sequence.tracker().FactsOf(1);
    EXPECT_EQ(facts.motion, Motion::kAtRest);
    EXPECT_EQ(facts.visibility, Visibility::kVisible);
  }
}

TEST(TrackerOnSequences, FollowsAThingThatSlidesByItself) {
  SequenceScript script = Table(4);
  script.events.push_back(
      {.object = 1, .begin_s = 1, .end_s = 2, .what = MoveEvent{Beside(script, 1, {0.03, 0, 0})}});
  TrackedSequence sequence(script);
  const std::vector<TrackedFrame> frames = sequence.Run();
  const int first = FirstOf(frames, Kind::kMove, 1);
  EXPECT_GE(first, 30);
  EXPECT_LE(first, 38);
  EXPECT_EQ(CountOf(frames, Kind::kRemove), 0);
  const Vector3 end_W = script.scene.objects[1].X_WO.translation() + Vector3(0.03, 0, 0);
  ASSERT_NE(sequence.Find(1), nullptr);
  EXPECT_LT((sequence.Find(1)->X_WB.translation() - end_W).norm(), 0.003) << "warp of 1.3 mm";
  EXPECT_EQ(sequence.tracker().FactsOf(1).motion, Motion::kAtRest);
  for (const TrackedFrame& frame : frames) {
    for (const TrackChange& change : frame.changes) {
      if (change.kind == Kind::kMove) {
        EXPECT_EQ(change.body, 1) << "frame " << frame.frame;
      }
      EXPECT_LT(frame.frame, 85) << "it rests since 2 s";
    }
  }
}

TEST(TrackerOnSequences, TellsWithinThreeFramesThatAThingIsGone) {
  SequenceScript script = Table(3);
  script.events.push_back({.object = 2, .begin_s = 1, .what = VanishEvent{}});
  TrackedSequence sequence(script);
  const std::vector<TrackedFrame> frames = sequence.Run();
  const int first = FirstOf(frames, Kind::kRemove, 2);
  EXPECT_GE(first, 30);
  EXPECT_LE(first, 33);
  EXPECT_EQ(CountOf(frames, Kind::kRemove), 1);
  EXPECT_EQ(CountOf(frames, Kind::kMove), 0);
}

TEST(TrackerOnSequences, CoversAThingThatAppearsUntilItIsInterpreted) {
  SequenceScript script = Table(3);
  script.events.push_back(
      {.object = 3, .begin_s = 1, .what = AppearEvent{script.scene.objects[3].X_WO}});
  TrackedSequence sequence(script);
  const std::vector<TrackedFrame> frames = sequence.Run();
  EXPECT_EQ(FirstOf(frames, Kind::kMovers), 30);
  int requested = -1;
  for (const TrackedFrame& frame : frames) {
    for (const RegionRequest& request : frame.requests) {
      if (!request.is_whole_view && requested < 0) requested = frame.frame;
    }
  }
  EXPECT_GE(requested, 38);
  EXPECT_LE(requested, 42);
  // The last word about movers is that there is none.
  std::vector<MoverPiece> pieces;
  for (const TrackedFrame& frame : frames) {
    for (const TrackChange& change : frame.changes) {
      if (change.kind == Kind::kMovers) pieces = change.pieces;
    }
  }
  EXPECT_TRUE(pieces.empty());
  EXPECT_EQ(CountOf(frames, Kind::kMove) + CountOf(frames, Kind::kRemove), 0);
}

TEST(TrackerOnSequences, AHandThatPassesChangesNothingOfWhatItHides) {
  SequenceScript script = Table(4);
  SimulatedHand hand{.name = "hand", .shape = MakeHand(0.06)};
  // Across the table, between the camera and the things.
  for (int i = 0; i <= 4; ++i) {
    const double y = -0.4 + 0.2 * i;
    const Pose X_WH = LookAt(Vector3(0.55, y, 1.1), Vector3(0.85, y, 1.0));
    hand.waypoints.push_back({1 + 0.4 * i, X_WH});
  }
  script.hands.push_back(hand);
  TrackedSequence sequence(script);
  const std::vector<TrackedFrame> frames = sequence.Run();
  EXPECT_EQ(CountOf(frames, Kind::kRemove), 0);
  EXPECT_EQ(CountOf(frames, Kind::kMove), 0);
  EXPECT_GT(CountOf(frames, Kind::kMovers), 20);
  EXPECT_GE(FirstOf(frames, Kind::kMovers), 30);
  for (const TrackedFrame& frame : frames) {
    for (const RegionRequest& request : frame.requests) EXPECT_TRUE(request.is_whole_view);
    EXPECT_TRUE(frame.frame < 82 || frame.changes.empty()) << "frame " << frame.frame;
  }
}

// A thing that jumps by a few millimetres in any direction is told, and one beside it is not.
TEST(TrackerOnSequences, TellsSmallJumps) {
  for (const auto& [shift_m, within_frames] : {std::pair{0.005, 3}, {0.002, 9}}) {
    for (const std::uint64_t seed : {1U, 2U, 4U, 6U}) {
      SequenceScript script = Table(3, seed);
      const std::size_t object = 1 + seed % (script.scene.objects.size() - 1);
      const double angle = 2.4 * static_cast<double>(seed);
      const Vector3 shift_W = shift_m * Vector3(std::cos(angle), std::sin(angle), 0);
      script.events.push_back({.object = object,
                               .begin_s = 2,
                               .end_s = 2.001,
                               .what = MoveEvent{Beside(script, object, shift_W)}});
      TrackedSequence sequence(script);
      const std::vector<TrackedFrame> frames = sequence.Run();
      const auto id = static_cast<BodyId>(object);
      const int first = FirstOf(frames, Kind::kMove, id);
      EXPECT_GE(first, 60) << "seed " << seed << ", " << shift_m;
      EXPECT_LE(first, 61 + within_frames) << "seed " << seed << ", " << shift_m;
      for (const TrackedFrame& frame : frames) {
        for (const TrackChange& change : frame.changes) EXPECT_EQ(change.body, id);
      }
      const Vector3 end_W = script.scene.objects[object].X_WO.translation() + shift_W;
      EXPECT_LT((sequence.Find(id)->X_WB.translation() - end_W).norm(), 0.003);
    }
  }
}

// A table before a still Kinect that looks down on it, with a box, a cup, and a higher box that hides
// a part of the cup.
enum RowIds : std::size_t { kSlidingBox = 1, kCup, kHidingBox };
SequenceScript Row(std::uint64_t seed) {
  constexpr double kTop_m = 0.75;
  SequenceScript script;
  script.duration_s = 4;
  script.seed = seed;
  script.scene.objects = {
      MakeTop("table", {.area_W = {Vector2(-0.2, -1.2), Vector2(1.8, 1.2)}, .top_m = kTop_m})};
  const auto add = [&](const char* name, const Shape& shape, double height_m, double x, double y) {
    script.scene.objects.push_back(
        {.name = name,
         .parts = {{.X_FS = MakeTranslation(0, 0, 0.5 * height_m), .shape = shape}},
         .X_WO = MakeTranslation(x, y, kTop_m)});
  };
  add("box", Box{{0.06, 0.09, 0.08}}, 0.08, 0.7, -0.2);
  // Wider above than below: from here nothing of its side is seen.
  add("cup", Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.05, .length_m = 0.08}, 0.08, 0.8, 0.1);
  add("hiding box", Box{{0.05, 0.08, 0.12}}, 0.12, 0.68, 0.14);
  SequenceSensor sensor;
  sensor.name = "head";
  sensor.mount = LookAt(Vector3(0.15, 0, 1.55), Vector3(0.72, 0, kTop_m));
  sensor.device_seed = 100 + seed;
  script.sensors.push_back(sensor);
  return script;
}

// A motion along the faces that a camera sees changes none of their depths: the outline tells it.
TEST(TrackerOnSequences, TellsJumpsAlongTheVisibleFaces) {
  for (const auto& [shift_m, within_frames] : {std::pair{0.005, 3}, {0.002, 9}}) {
    for (const std::size_t object : {kSlidingBox, kCup}) {
      for (const std::uint64_t seed : {1U, 2U, 3U}) {
        SequenceScript script = Row(seed);
        const Vector3 shift_W = (seed == 2 ? -1 : 1) * Vector3(0, shift_m, 0);
        script.events.push_back({.object = object,
                                 .begin_s = 2.5,
                                 .end_s = 2.501,
                                 .what = MoveEvent{Beside(script, object, shift_W)}});
        TrackedSequence sequence(script);
        const std::vector<TrackedFrame> frames = sequence.Run();
        const auto id = static_cast<BodyId>(object);
        const int first = FirstOf(frames, Kind::kMove, id);
        EXPECT_GE(first, 75) << object << ", seed " << seed << ", " << shift_m;
        EXPECT_LE(first, 76 + within_frames) << object << ", seed " << seed << ", " << shift_m;
        for (const TrackedFrame& frame : frames) {
          for (const TrackChange& change : frame.changes) EXPECT_EQ(change.body, id);
        }
        const Vector3 end_W = script.scene.objects[object].X_WO.translation() + shift_W;
        EXPECT_LT((sequence.Find(id)->X_WB.translation() - end_W).norm(), 0.0015)
            << object << ", seed " << seed << ", " << shift_m;
      }
    }
  }
}

// The model is longer than the box, so that rays pass through a fourth of it also at rest.
TEST(TrackerOnSequences, FollowsAThingWhoseModelIsTooLarge) {
  for (const double angle : {0.5, 2.5, 4.5}) {
    SequenceScript script = Row(1);
    const Vector3 shift_W = 0.06 * Vector3(std::cos(angle), std::sin(angle), 0);
    script.events.push_back({.object = kSlidingBox,
                             .begin_s = 2,
                             .end_s = 2.2,
                             .what = MoveEvent{Beside(script, kSlidingBox, shift_W)}});
    TrackedSequence sequence(script);
    HybridModel model;
    model.shapes.push_back(
        {.X_OS = MakeTranslation(0, -0.02, 0.04), .shape = Box{{0.06, 0.13, 0.08}}});
    sequence.SetModel(kSlidingBox, model);
    const std::vector<TrackedFrame> frames = sequence.Run();
    EXPECT_EQ(CountOf(frames, Kind::kRemove), 0) << angle;
    EXPECT_GE(FirstOf(frames, Kind::kMove, kSlidingBox), 60) << angle;
    EXPECT_LE(FirstOf(frames, Kind::kMove, kSlidingBox), 63) << angle;
    const Vector3 end_W = script.scene.objects[kSlidingBox].X_WO.translation() + shift_W;
    ASSERT_NE(sequence.Find(kSlidingBox), nullptr);
    // Within its excess nothing tells where in the model the box is.
    EXPECT_LT((sequence.Find(kSlidingBox)->X_WB.translation() - end_W).norm(), 0.04) << angle;
  }
}

// A thing that moves in front changes which pixels show the cup. The shift that they have told until
// then is not forgotten, and uncovered pixels tell none.
TEST(TrackerOnSequences, TellsAJumpWhileWhatHidesAPartMoves) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SequenceScript script = Row(seed);
    const Vector3 shift_W(0.001, 0.002, 0);
    script.events = {{.object = kCup,
                      .begin_s = 2.5,
                      .end_s = 2.501,
                      .what = MoveEvent{Beside(script, kCup, shift_W)}},
                     {.object = kHidingBox,
                      .begin_s = 2.53,
                      .end_s = 2.531,
                      .what = MoveEvent{Beside(script, kHidingBox, {0, 0.02, 0})}}};
    TrackedSequence sequence(script);
    const std::vector<TrackedFrame> frames = sequence.Run();
    const int first = FirstOf(frames, Kind::kMove, kCup);
    EXPECT_GE(first, 75) << "seed " << seed;
    EXPECT_LE(first, 85) << "seed " << seed;
    const Vector3 end_W = script.scene.objects[kCup].X_WO.translation() + shift_W;
    EXPECT_LT((sequence.Find(kCup)->X_WB.translation() - end_W).norm(), 0.0015) << "seed " << seed;
  }
}

TEST(TrackerOnSequences, WhatIsUncoveredRestsToTheBit) {
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    SequenceScript script = Row(seed);
    script.events = {
        {.object = kHidingBox, .begin_s = 2, .what = VanishEvent{}},
        {.object = kHidingBox,
         .begin_s = 3,
         .what = AppearEvent{Beside(script, kHidingBox, {0, -0.02, 0})}},
    };
    TrackedSequence sequence(script);
    const std::vector<TrackedFrame> frames = sequence.Run();
    EXPECT_EQ(CountOf(frames, Kind::kRemove), 1) << "seed " << seed;
    EXPECT_EQ(CountOf(frames, Kind::kMove), 0) << "seed " << seed;
  }
}

// The hand that takes it is a mover, the thing is followed until it leaves the view, and then it is
// gone. Its neighbours stay.
TEST(TrackerOnSequences, FollowsAThingThatAHandTakesAway) {
  for (const std::uint64_t seed : {1U, 4U}) {
    SequenceScript script = Table(4, seed);
    const std::size_t object = 1 + seed % (script.scene.objects.size() - 1);
    TakeByHand(object, 2, {.from_W = ReachFrom(script, object, 0), .travel_s = 0.8}, script);
    TrackedSequence sequence(script);
    const std::vector<TrackedFrame> frames = sequence.Run();
    const auto id = static_cast<BodyId>(object);
    EXPECT_GE(FirstOf(frames, Kind::kMove, id), 60);
    EXPECT_LE(FirstOf(frames, Kind::kMove, id), 66);
    EXPECT_EQ(CountOf(frames, Kind::kRemove), 1);
    EXPECT_EQ(sequence.Find(id), nullptr);
    EXPECT_GE(FirstOf(frames, Kind::kMovers), 36);
    for (const TrackedFrame& frame : frames) {
      for (const TrackChange& change : frame.changes) {
        EXPECT_TRUE(change.kind == Kind::kMovers || change.body == id) << frame.frame;
      }
    }
  }
}

// An interpretation that failed leaves its view unknown, and is asked for again.
TEST(TrackerOnSequences, AsksAgainForAViewThatCouldNotBeInterpreted) {
  const SequenceScript script = Table(0.1);
  const SequenceRenderer renderer(script);
  const std::vector<KnownBody> bodies = KnownBodies(script.scene);
  SensorView view("head", CameraOf(script.sensors[0].camera), script.sensors[0].noise);
  Tracker tracker;
  const auto step = [&](int seconds) {
    const SequenceFrame rendered = renderer.Render(0, 0);
    auto image = std::make_shared<DepthImage>();
    image->width = rendered.depth.width;
    image->height = rendered.depth.height;
    image->depth_m = rendered.depth.depth_m;
    const Stamp stamp{std::chrono::seconds(1000 + seconds)};
    return tracker.Step(view.Observe({stamp, rendered.camera.X_WC, image}, bodies, {}), bodies);
  };
  const StepResult first = step(0);
  ASSERT_EQ(first.requests.size(), 1U);
  EXPECT_TRUE(tracker.Finish("head", first.requests[0].number, false).empty());
  EXPECT_TRUE(step(1).requests.empty()) << "not with every frame";
  const StepResult again = step(4);
  ASSERT_EQ(again.requests.size(), 1U);
  EXPECT_TRUE(again.requests[0].is_whole_view);
  tracker.Finish("head", again.requests[0].number);
  EXPECT_TRUE(step(9).requests.empty());
}

TEST(TrackerOnSequences, SameFramesGiveTheSameChanges) {
  SequenceScript script = Table(2);
  PushByHand(1, {0.8, 1.4}, Beside(script, 1, {0.05, 0.02, 0}),
             {.from_W = ReachFrom(script, 1, 0), .travel_s = 0.5}, script);
  const std::vector<TrackedFrame> a = TrackedSequence(script).Run();
  const std::vector<TrackedFrame> b = TrackedSequence(script).Run();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    ASSERT_EQ(a[k].changes.size(), b[k].changes.size()) << k;
    for (std::size_t i = 0; i < a[k].changes.size(); ++i) {
      EXPECT_EQ(a[k].changes[i].kind, b[k].changes[i].kind);
      EXPECT_TRUE(a[k].changes[i].X_WB.matrix() == b[k].changes[i].X_WB.matrix());
      EXPECT_EQ(a[k].changes[i].pieces.size(), b[k].changes[i].pieces.size());
    }
  }
}

}  // namespace
}  // namespace cwm::perception
