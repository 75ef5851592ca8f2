// Two depth cameras at one table: what they tell of each other, and that a wrong pose of one of
// them changes nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "perception/interpret_scene.h"
#include "server/core/live/live_world.h"
#include "tests/server/core/live/cameras_at_a_table.h"

namespace cwm::server {
namespace {

using perception::SequenceScript;

// A world that several sensors stream into in turn. What runs beside the frames is done between
// them.
class Sensors {
 public:
  explicit Sensors(int max_threads = 1) : max_threads_(max_threads) {}

  Pose TruePose(std::size_t s) const { return CameraAt(script(), script().sensors[s], 0).X_WC; }
  const SequenceScript& script() const { return renderer_.script(); }

  void Open(std::size_t s, const Pose& X_WC) {
    SensorCalibration calibration{.sensor = script().sensors[s].name};
    calibration.X_WC = X_WC;
    auto opened = live_->Open(calibration, {});
    ASSERT_TRUE(opened.ok()) << opened.status();
    streams_[s] = *std::move(opened);
  }

  FrameOutcome Process(std::size_t s) {
    const perception::SequenceFrame rendered = renderer_.Render(s, frame_[s]++);
    LiveFrame frame;
    frame.stamp = perception::Stamp(std::chrono::duration_cast<perception::Stamp::duration>(
        std::chrono::duration<double>(rendered.stamp_s)));
    const perception::PinholeCamera& camera = rendered.camera;
    frame.camera = {.pinhole = {.focal_u_px = camera.focal_px,
                                .focal_v_px = camera.focal_px,
                                .center_u_px = camera.center_x_px,
                                .center_v_px = camera.center_y_px},
                    .width = camera.width,
                    .height = camera.height};
    auto image = std::make_shared<perception::DepthImage>();
    image->width = rendered.depth.width;
    image->height = rendered.depth.height;
    image->depth_m = rendered.depth.depth_m;
    frame.image = std::move(image);
    frame.received = frame.begun = frame.decoded = Clock::now();
    auto outcome = streams_[s]->Process(frame);
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    while (runs_at_once_ && RunBeside()) {
    }
    if (!outcome.ok()) return {};
    changes_.Append(outcome->changes);
    return *std::move(outcome);
  }
  // Runs the oldest task beside the frames; false if there is none.
  bool RunBeside() {
    if (beside_.empty()) return false;
    const std::function<void()> task = std::move(beside_.front());
    beside_.pop_front();
    task();
    return true;
  }

  // The last outcome of the last sensor.
  FrameOutcome Process(std::initializer_list<std::size_t> sensors, int frames) {
    FrameOutcome last;
    for (int k = 0; k < frames; ++k) {
      for (const std::size_t s : sensors) last = Process(s);
    }
    return last;
  }

  // A sensor that comes later has missed the frames until now.
  void Skip(std::size_t s, int frames) { frame_[s] += frames; }

  FrameChanges TakeChanges() { return std::exchange(changes_, {}); }

  SensorStatus StatusOf(std::size_t s) const {
    for (SensorStatus& status : live_->Sensors()) {
      if (status.calibration.sensor == script().sensors[s].name) return status;
    }
    return {};
  }

  // Objects at the places of things, and at none.
  struct Census {
    int things = 0, doubles = 0, others = 0;
  };
  Census Count() const {
    Census census;
    std::vector<int> at(kThings, 0);
    for (const auto& object : world_->Snapshot()->objects()) {
      if (object->kind != collision::ObjectKind::kObject) continue;
      bool is_thing = false;
      for (int i = 0; i < kThings; ++i) {
        const Aabb bounds = BoundsInWorld(script().scene.objects[static_cast<std::size_t>(i) + 1]);
        if ((object->bounds_W.center() - bounds.center()).norm() > 0.05) continue;
        is_thing = true;
        census.doubles += at[static_cast<std::size_t>(i)]++ > 0 ? 1 : 0;
      }
      census.things += is_thing ? 1 : 0;
      census.others += is_thing ? 0 : 1;
    }
    return census;
  }

  const int max_threads_;
  const perception::SequenceRenderer renderer_{CamerasAtATable()};
  std::deque<std::function<void()>> beside_;
  const std::shared_ptr<World> world_ = std::make_shared<World>("w", "uid", Retention{});
  const std::shared_ptr<LiveWorld> live_ =
      std::make_shared<LiveWorld>(world_, LiveServices{.interpret = perception::InterpretScene,
                                                       .run_beside =
                                                           [this](std::function<void()> task) {
                                                             beside_.push_back(std::move(task));
                                                             return true;
                                                           },
                                                       .max_threads = max_threads_});
  std::unique_ptr<SensorStream> streams_[3];
  int frame_[3] = {};
  FrameChanges changes_;
  bool runs_at_once_ = true;
};

class SensorsTest : public testing::Test, protected Sensors {
 protected:
  // Each thing is there once, and stays as it is in so many frames of both sensors.
  FrameOutcome ExpectNothingChanges(int frames) {
    TakeChanges();
    const FrameOutcome last = Process({0, 1}, frames);
    const FrameChanges changes = TakeChanges();
    EXPECT_THAT(changes.added, testing::IsEmpty());
    EXPECT_THAT(changes.moved, testing::IsEmpty());
    EXPECT_THAT(changes.removed, testing::IsEmpty());
    const Census census = Count();
    EXPECT_EQ(census.things, kThings);
    EXPECT_EQ(census.doubles, 0);
    return last;
  }
};

TEST_F(SensorsTest, SensorsThatAgreeFollowOneWorldAndTellThePosesOfEachOther) {
  for (const std::size_t s : {0, 1}) Open(s, TruePose(s));
  Process({0, 1}, 30);
  EXPECT_EQ(ExpectNothingChanges(60).reason, "");
  EXPECT_EQ(Count().others, 0);
  for (const std::size_t s : {0, 1}) {
    const SensorStatus status = StatusOf(s);
    EXPECT_THAT(status.conflicts, testing::IsEmpty());
    ASSERT_TRUE(status.estimate.has_value()) << status.estimate_note;
    EXPECT_LT(status.estimate->translation_error_m, 4 * status.estimate->sigma_m);
    EXPECT_LT(status.estimate->rotation_error_rad, 4 * status.estimate->sigma_rad);
  }
}

TEST_F(SensorsTest, AWrongPoseIsToldWithMillimetresAndChangesNothing) {
  Open(0, TruePose(0));
  Process({0}, 20);
  const Census before = Count();
  EXPECT_EQ(before.things, kThings);
  TakeChanges();
  Open(1, Wrong(TruePose(1), 0.03, 2));
  Skip(1, 20);
  const std::int64_t revision = world_->Snapshot()->revision().value;
  for (int k = 0; k < 150; ++k) {
    EXPECT_EQ(Process(0).reason, "");
    const FrameOutcome outcome = Process(1);
    EXPECT_EQ(outcome.fate, FrameFate::kProcessed);
    if (k < 10) continue;  // it is being compared
    EXPECT_EQ(outcome.reason, "CALIBRATION_CONFLICT");
    EXPECT_THAT(outcome.message, testing::AllOf(testing::HasSubstr("\"camera_1\""),
                                                testing::HasSubstr(" mm apart")));
  }
  EXPECT_EQ(world_->Snapshot()->revision().value, revision);
  const FrameChanges changes = TakeChanges();
  EXPECT_THAT(changes.added, testing::IsEmpty());
  EXPECT_THAT(changes.moved, testing::IsEmpty());
  EXPECT_THAT(changes.removed, testing::IsEmpty());
  EXPECT_THAT(changes.replaced, testing::IsEmpty());
  EXPECT_THAT(changes.movers, testing::IsEmpty());
  // Both name the other one.
  EXPECT_THAT(StatusOf(0).conflicts, testing::ElementsAre(testing::HasSubstr("\"camera_2\"")));
  EXPECT_THAT(StatusOf(1).conflicts, testing::ElementsAre(testing::HasSubstr("\"camera_1\"")));
}

TEST_F(SensorsTest, TheEstimateBringsAWrongSensorBack) {
  Open(0, TruePose(0));
  Process({0}, 20);
  Open(1, Wrong(TruePose(1), 0.03, 2));
  Skip(1, 20);
  EXPECT_EQ(Process({0, 1}, 20).reason, "CALIBRATION_CONFLICT");
  const auto X_WC = live_->EstimatedPose("camera_2");
  ASSERT_TRUE(X_WC.has_value()) << StatusOf(1).estimate_note;
  EXPECT_LT((X_WC->translation() - TruePose(1).translation()).norm(), 0.01);
  ASSERT_TRUE(live_->SetSensorPose("camera_2", *X_WC).ok());
  EXPECT_EQ(Process({0, 1}, 40).reason, "");
  EXPECT_THAT(StatusOf(1).conflicts, testing::IsEmpty());
  ExpectNothingChanges(40);
}

TEST_F(SensorsTest, FramesAreNumberedInTheOrderInWhichTheWorldTookThem) {
  for (const std::size_t s : {0, 1}) Open(s, TruePose(s));
  std::uint64_t last = 0;
  for (const std::size_t s : {0, 1, 1, 0, 1}) EXPECT_EQ(Process(s).number, ++last);
  --frame_[0];
  const FrameOutcome stale = Process(0);
  EXPECT_EQ(stale.fate, FrameFate::kRefused);
  EXPECT_EQ(stale.number, 0U);
  EXPECT_EQ(Process(0).number, ++last);
}

// Who waits for it before the next frame gets the same world from the same frames.
TEST_F(SensorsTest, AnAnswerTellsThatSomethingRunsBesideTheFrames) {
  runs_at_once_ = false;
  for (const std::size_t s : {0, 1}) Open(s, TruePose(s));
  int tasks = 0;
  for (int k = 0; k < 80; ++k) {
    for (const std::size_t s : {0, 1}) {
      const bool is_told = Process(s).interpreting;
      const bool runs = !beside_.empty();
      EXPECT_TRUE(is_told || !runs) << "frame " << k << " of camera " << s + 1;
      while (RunBeside()) ++tasks;
    }
  }
  EXPECT_GE(tasks, 5) << "two views, a comparison of each, and a fusion";
}

TEST_F(SensorsTest, ASensorIsUsedWhereItAgreesWithTheOnesBefore) {
  Open(0, TruePose(0));
  Process({0}, 20);
  const Pose X_WC_given = Wrong(TruePose(1), 0.012, 0.6);
  Open(1, X_WC_given);
  Skip(1, 20);
  Process({0, 1}, 40);
  ExpectNothingChanges(100);
  const FrameOutcome outcome = Process(1);
  const Vector3 p_W(0.7, 0, kTableTop_m);
  const Vector3 p_C = TruePose(1).inverse() * p_W;
  EXPECT_GT((X_WC_given * p_C - p_W).norm(), 0.01);
  EXPECT_LT((outcome.X_WC * p_C - p_W).norm(), 0.006);
  // It is told, and the given pose stays what it was.
  EXPECT_EQ(outcome.fate, FrameFate::kProcessed);
  EXPECT_EQ(outcome.reason, "CALIBRATION_CONFLICT");
  EXPECT_THAT(outcome.message,
              testing::AllOf(testing::HasSubstr("\"camera_1\""), testing::HasSubstr(" mm apart")));
  EXPECT_EQ(StatusOf(1).X_WC.matrix(), X_WC_given.matrix());
  EXPECT_EQ(Process(0).X_WC.matrix(), TruePose(0).matrix());
}

TEST_F(SensorsTest, AnotherPoseOfTheFirstSensorMovesWhatAllOfThemSee) {
  Open(0, Wrong(TruePose(0), 0.012, 0.6));
  Process({0}, 20);
  for (const std::size_t s : {1, 2}) {
    Open(s, TruePose(s));
    Skip(s, 20);
  }
  Process({0, 1, 2}, 40);
  const auto worst_m = [this] {
    double worst = 0;
    for (const auto& object : world_->Snapshot()->objects()) {
      double nearest_m = 1;
      for (int i = 0; i < kThings; ++i) {
        const Aabb bounds = BoundsInWorld(script().scene.objects[static_cast<std::size_t>(i) + 1]);
        nearest_m = std::min(nearest_m, (object->bounds_W.center() - bounds.center()).norm());
      }
      if (object->kind == collision::ObjectKind::kObject) worst = std::max(worst, nearest_m);
    }
    return worst;
  };
  EXPECT_GT(worst_m(), 0.01);
  ASSERT_TRUE(live_->SetSensorPose("camera_1", TruePose(0)).ok());
  Process({0, 1, 2}, 100);
  EXPECT_LT(worst_m(), 0.01);
  const Census census = Count();
  EXPECT_EQ(census.things, kThings);
  EXPECT_EQ(census.doubles, 0);
}

TEST_F(SensorsTest, ShapesAtRestAreFittedToWhatAllSensorsSee) {
  const auto observed = [this] {
    double sum = 0;
    int count = 0;
    for (const auto& object : world_->Snapshot()->objects()) {
      if (object->kind != collision::ObjectKind::kObject || object->model().shapes.empty())
        continue;
      sum += object->model().shapes.front().fit->observed_fraction;
      ++count;
    }
    return sum / count;
  };
  for (const std::size_t s : {0, 1, 2}) Open(s, TruePose(s));
  Process({0, 1, 2}, 20);
  const double before = observed();
  TakeChanges();
  Process({0, 1, 2}, 60);
  const FrameChanges changes = TakeChanges();
  EXPECT_GE(changes.replaced.size(), 6U);
  EXPECT_THAT(changes.added, testing::IsEmpty());
  EXPECT_THAT(changes.removed, testing::IsEmpty());
  EXPECT_GT(observed(), before + 0.15);
  const Census census = Count();
  EXPECT_EQ(census.things, kThings);
  EXPECT_EQ(census.doubles, 0);
  for (const std::size_t s : {0, 1, 2}) EXPECT_THAT(StatusOf(s).conflicts, testing::IsEmpty());
  // Once is enough.
  Process({0, 1, 2}, 60);
  EXPECT_THAT(TakeChanges().replaced, testing::IsEmpty());
}

// One view shows the front of a can as a thing of its own; the whole can is found later.
TEST_F(SensorsTest, WhatIsAPartOfAnotherObjectIsRemovedWhenShapesAreFitted) {
  for (const std::size_t s : {0, 1, 2}) Open(s, TruePose(s));
  Process({0, 1, 2}, 20);
  const Vector3 foot = script().scene.objects[2].X_WO.translation();
  auto slab = std::make_shared<HybridModel>();
  slab->shapes.push_back({.shape = Box{.size_m = {0.02, 0.03, 0.07}}});
  const collision::Change put{
      collision::PutObject{.name = "slab",
                           .kind = collision::ObjectKind::kObject,
                           .owner = collision::Owner::kPerception,
                           .X_WO = MakeTranslation(foot.x() - 0.0275, foot.y(), foot.z() + 0.04),
                           .geometry = collision::Prepare(std::move(slab)),
                           .supported_by = ""},
      std::nullopt};
  const auto written = world_->Apply({&put, 1}, {});
  ASSERT_TRUE(written.ok()) << written.status();
  TakeChanges();
  Process({0, 1, 2}, 60);
  EXPECT_THAT(TakeChanges().removed, testing::ElementsAre("slab"));
  EXPECT_EQ(world_->Snapshot()->Find("slab"), nullptr);
  const Census census = Count();
  EXPECT_EQ(census.things, kThings);
  EXPECT_EQ(census.doubles, 0);
  EXPECT_EQ(census.others, 0);
}

// Everything that a client can read of a world's geometry, bit by bit.
std::string BytesOf(const collision::WorldSnapshot& snapshot) {
  std::string bytes = std::to_string(snapshot.revision().value);
  const auto add = [&bytes](const double* numbers, std::size_t count) {
    bytes.append(reinterpret_cast<const char*>(numbers), count * sizeof(double));
  };
  for (const auto& object : snapshot.objects()) {
    bytes += object->Uid() + object->name;
    add(object->X_WO.data(), 16);
    add(object->bounds_W.min().data(), 3);
    add(object->bounds_W.max().data(), 3);
    for (const ShapePart& part : object->model().shapes) {
      add(part.X_OS.data(), 16);
      if (part.fit.has_value()) add(&part.fit->observed_fraction, 1);
    }
  }
  return bytes;
}

// What happened in a run, in order: a frame of a sensor, or -1 for a task beside the frames, which
// commits what it found.
using Trace = std::vector<int>;

std::string Replayed(const Trace& trace, int max_threads) {
  Sensors sensors(max_threads);
  sensors.runs_at_once_ = false;
  for (const std::size_t s : {0, 1, 2}) sensors.Open(s, sensors.TruePose(s));
  for (const int event : trace) {
    if (event < 0) {
      sensors.RunBeside();
    } else {
      sensors.Process(static_cast<std::size_t>(event));
    }
  }
  return BytesOf(*sensors.world_->Snapshot());
}

TEST(SensorTraceTest, TheSameFramesAndCommitsInTheSameOrderGiveTheSameBytes) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    std::mt19937 random(seed);
    Trace trace;
    for (int k = 0; k < 200; ++k) trace.push_back(static_cast<int>(random() % 4) - 1);
    const std::string bytes = Replayed(trace, 1);
    EXPECT_EQ(bytes, Replayed(trace, 1)) << seed;
    EXPECT_EQ(bytes, Replayed(trace, 2)) << seed;
  }
}

}  // namespace
}  // namespace cwm::server
