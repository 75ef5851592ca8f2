// What one sensor sees does not undo what only another one can see.
#include <gtest/gtest.h>

#include "perception/live/tracker.h"

namespace cwm::perception {
namespace {

constexpr BodyId kBox = 7;
constexpr int kExpected_px = 600;

KnownBody BoxBody() {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Box{.size_m = {0.1, 0.1, 0.1}}});
  return {.id = kBox, .name = "box", .X_WB = MakeTranslation(0, 0, 1), .model = std::move(model)};
}

// Sensors whose views are known, in frames of 33 ms.
class Sensors {
 public:
  explicit Sensors(const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      const StepResult first = tracker_.Step(FrameOf(name, {}), bodies_);
      EXPECT_EQ(first.requests.size(), 1U);
      tracker_.Finish(name, first.requests.front().number);
    }
  }

  // True if the frame tells that the body is gone.
  bool IsGone(const std::string& sensor, BodyEvidence evidence) {
    evidence.id = kBox;
    const StepResult result = tracker_.Step(FrameOf(sensor, {evidence}), bodies_);
    for (const TrackChange& change : result.changes) {
      if (change.kind == TrackChange::Kind::kRemove && change.body == kBox) return true;
    }
    return false;
  }

 private:
  FrameEvidence FrameOf(const std::string& sensor, std::vector<BodyEvidence> bodies) {
    FrameEvidence frame;
    frame.sensor = sensor;
    frame.stamp = Stamp(std::chrono::milliseconds(33 * ++frame_));
    frame.is_still = true;
    frame.has_reference = true;
    frame.camera.width = frame.camera.height = 8;
    auto image = std::make_shared<DepthImage>();
    image->width = image->height = 8;
    image->depth_m.assign(64, 2);
    frame.image = std::move(image);
    auto classes = std::make_shared<FrameClasses>();
    classes->width = classes->height = 8;
    classes->block_columns = classes->block_rows = 1;
    classes->pixels.assign(64, PixelClass::kConsistent);
    classes->hot_blocks.assign(1, 0);
    frame.classes = std::move(classes);
    frame.bodies = std::move(bodies);
    return frame;
  }

  Tracker tracker_;
  const std::vector<KnownBody> bodies_ = {BoxBody()};
  int frame_ = 0;
};

BodyEvidence Seen() { return {.expected = kExpected_px, .consistent = kExpected_px}; }
BodyEvidence SeenThrough() {
  return {
      .expected = kExpected_px, .farther = kExpected_px, .is_hot = true, .passed = kExpected_px};
}
BodyEvidence Hidden() { return {.expected = kExpected_px, .nearer = kExpected_px}; }
BodyEvidence BehindTheRobot() { return {.expected = kExpected_px, .hidden = kExpected_px}; }
BodyEvidence Missing() { return {.expected = kExpected_px, .missing = kExpected_px}; }

TEST(EvidenceOfSensorsTest, OneSensorTellsWhatIsGone) {
  Sensors sensors({"a"});
  int frames = 1;
  while (frames < 30 && !sensors.IsGone("a", SeenThrough())) ++frames;
  EXPECT_LE(frames, 6);
}

TEST(EvidenceOfSensorsTest, WhatIsHiddenFromASensorStaysThere) {
  for (const BodyEvidence& evidence : {Hidden(), BehindTheRobot(), Missing()}) {
    Sensors sensors({"a", "b"});
    for (int k = 0; k < 300; ++k) {
      EXPECT_FALSE(sensors.IsGone("a", Seen())) << k;
      EXPECT_FALSE(sensors.IsGone("b", evidence)) << k;
    }
    for (int k = 0; k < 300; ++k) EXPECT_FALSE(sensors.IsGone("b", evidence)) << k;
  }
}

TEST(EvidenceOfSensorsTest, WhatASensorSeesIsNotRemovedByOneThatSeesThroughIt) {
  Sensors sensors({"a", "b"});
  for (int k = 0; k < 300; ++k) {
    EXPECT_FALSE(sensors.IsGone("b", SeenThrough())) << k;
    EXPECT_FALSE(sensors.IsGone("a", Seen())) << k;
  }
}

TEST(EvidenceOfSensorsTest, WhatTheFirstNoLongerSeesIsRemovedByTheSecond) {
  Sensors sensors({"a", "b"});
  for (int k = 0; k < 30; ++k) EXPECT_FALSE(sensors.IsGone("a", Seen()));
  for (int k = 0; k < 30; ++k) EXPECT_FALSE(sensors.IsGone("b", Hidden()));
  // Both see through it now: it takes a few frames of each.
  int frames = 1;
  while (frames < 60 && !sensors.IsGone("a", SeenThrough()) &&
         !sensors.IsGone("b", SeenThrough())) {
    ++frames;
  }
  EXPECT_LE(frames, 6);
}

}  // namespace
}  // namespace cwm::perception
