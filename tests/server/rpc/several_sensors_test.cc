// Three depth cameras stream into one world over a socket, with poses that are slightly wrong: what
// rests makes no revision, and what moves is told once.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/server/core/live/cameras_at_a_table.h"
#include "tests/server/rpc/depth_stream.h"
#include "tests/server/rpc/simulated_depth.h"

namespace cwm::server {
namespace {

constexpr std::size_t kCameras = 3;
constexpr std::size_t kMovedThing = 10;  // it hides no other thing on its way
constexpr double kPushBegin_s = 4, kPushEnd_s = 5;
const Vector3 kPush(-0.08, 0, 0);
constexpr double kMaxMiss_m = 0.005;  // of its way: noise, and the warp at two places

perception::SequenceScript PushedThing() {
  perception::SequenceScript script = CamerasAtATable();
  const Pose& X_WO = script.scene.objects[kMovedThing + 1].X_WO;
  script.events.push_back({.object = kMovedThing + 1,
                           .begin_s = kPushBegin_s,
                           .end_s = kPushEnd_s,
                           .what = perception::MoveEvent{
                               .X_WO = MakeTranslation(kPush.x(), kPush.y(), kPush.z()) * X_WO}});
  return script;
}

void SetPose(const Pose& X, v1::Pose& pose) {
  const Quaternion q(X.linear());
  pose.set_tx_m(X.translation().x());
  pose.set_ty_m(X.translation().y());
  pose.set_tz_m(X.translation().z());
  pose.set_qx(q.x());
  pose.set_qy(q.y());
  pose.set_qz(q.z());
  pose.set_qw(q.w());
}

Vector3 PlaceOf(const v1::Object& object) {
  const v1::Pose& pose = object.x_world_object();
  return {pose.tx_m(), pose.ty_m(), pose.tz_m()};
}

class SeveralSensorsTest : public RunningServer,
                           public ::testing::WithParamInterface<CalibrationError> {
 protected:
  struct Changes {
    std::set<std::string> added = {}, moved = {}, replaced = {}, removed = {}, movers = {};
  };

  SeveralSensorsTest() {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    // All stamps are past, however fast the frames are sent.
    start_s_ = std::chrono::duration<double>(now).count() - 2 * script().duration_s;
    for (std::size_t s = 0; s < kCameras; ++s) {
      streams_.push_back(std::make_unique<DepthStream>(*perception_));
      EXPECT_TRUE(streams_.back()->Send(CalibrationOf(s)));
    }
  }

  const perception::SequenceScript& script() const { return renderer_.script(); }
  Pose PoseOf(std::size_t s) const { return GivenPose(script(), s, GetParam()); }

  v1::SensorCalibration CalibrationOf(std::size_t s) const {
    const perception::PinholeCamera& camera = script().sensors[s].camera;
    v1::SensorCalibration calibration;
    calibration.set_sensor(script().sensors[s].name);
    SetPose(PoseOf(s), *calibration.mutable_x_world_sensor());
    *calibration.mutable_depth() = LayoutOf(camera);
    return calibration;
  }

  // Sends the frame of each camera. True if something is being interpreted beside the frames.
  bool ProcessAll(int frame) {
    bool is_interpreting = false;
    for (std::size_t s = 0; s < kCameras; ++s) {
      const perception::SequenceFrame rendered = renderer_.Render(s, frame);
      v1::SensorFrame sent;
      const auto stamp_ns = static_cast<std::int64_t>(
          1e9 * (start_s_ + rendered.time_s + 0.001 * static_cast<double>(s)));
      sent.mutable_frame_stamp()->set_seconds(stamp_ns / 1'000'000'000);
      sent.mutable_frame_stamp()->set_nanos(static_cast<std::int32_t>(stamp_ns % 1'000'000'000));
      sent.set_depth(reinterpret_cast<const char*>(rendered.depth.depth_m.data()),
                     rendered.depth.depth_m.size() * sizeof(float));
      const v1::StreamCloudsResponse answer = streams_[s]->MustProcess(sent);
      Take(answer.changes());
      is_interpreting |= answer.interpreting();
      reasons_[s] = answer.reason();
      revision_ = std::max(revision_, answer.revision());
    }
    return is_interpreting;
  }

  // The next frames of the script up to a time; whatever they begin is interpreted before the next.
  void ProcessUntil(double time_s) {
    while (renderer_.Render(0, next_frame_).time_s < time_s) {
      is_interpreting_ = ProcessAll(next_frame_++);
      if (is_interpreting_) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    }
  }

  void Take(const v1::FrameChanges& changes) {
    changes_.added.insert(changes.added().begin(), changes.added().end());
    changes_.moved.insert(changes.moved().begin(), changes.moved().end());
    changes_.replaced.insert(changes.replaced().begin(), changes.replaced().end());
    changes_.removed.insert(changes.removed().begin(), changes.removed().end());
    changes_.movers.insert(changes.movers().begin(), changes.movers().end());
  }

  std::vector<v1::Object> Things() {
    Call call;
    v1::ListObjectsResponse response;
    EXPECT_TRUE(world_->ListObjects(&call, {}, &response).ok());
    std::vector<v1::Object> things;
    for (const v1::Object& object : response.objects()) {
      if (object.kind() == v1::OBJECT_KIND_OBJECT) things.push_back(object);
    }
    return things;
  }

  const perception::SequenceRenderer renderer_{PushedThing()};
  double start_s_ = 0;
  int next_frame_ = 0;
  std::vector<std::unique_ptr<DepthStream>> streams_;
  Changes changes_;
  std::map<std::size_t, std::string> reasons_;
  std::int64_t revision_ = 0;
  bool is_interpreting_ = false;  // in the last frames
};

TEST_P(SeveralSensorsTest, WhatRestsMakesNoRevisionAndWhatMovesIsToldOnce) {
  // Shapes are fitted to all views once things have rested for a second, one round after the other.
  double settled_s = 3;
  do {
    settled_s += 0.5;
    ProcessUntil(settled_s);
  } while (is_interpreting_ && settled_s < kPushBegin_s - 1);
  EXPECT_EQ(Things().size(), kThings);
  changes_ = {};
  const std::int64_t settled = revision_;
  ProcessUntil(kPushBegin_s);
  EXPECT_EQ(revision_, settled) << "replaced " << ::testing::PrintToString(changes_.replaced)
                                << ", moved " << ::testing::PrintToString(changes_.moved);
  // The second and the third camera agree with the first: farther apart than 8 mm is told.
  EXPECT_EQ(reasons_[0], "");
  if (GetParam().shift_m == 0) {
    EXPECT_EQ(reasons_[1] + reasons_[2], "");
  } else if (GetParam().shift_m > 0.01) {
    EXPECT_EQ(reasons_[1], "CALIBRATION_CONFLICT");
    EXPECT_EQ(reasons_[2], "CALIBRATION_CONFLICT");
  }
  // The thing that will be pushed, as the world has it.
  const Vector3 p_W = BoundsInWorld(script().scene.objects[kMovedThing + 1]).center();
  const auto distance_m = [&](const v1::Object& object) { return (PlaceOf(object) - p_W).norm(); };
  const v1::Object before = std::ranges::min(Things(), {}, distance_m);
  ProcessUntil(7);
  EXPECT_THAT(changes_.moved, ::testing::ElementsAre(before.name()));
  EXPECT_THAT(changes_.added, ::testing::IsEmpty());
  EXPECT_THAT(changes_.removed, ::testing::IsEmpty());
  const std::vector<v1::Object> things = Things();
  EXPECT_EQ(things.size(), kThings);
  const auto after = std::ranges::find(things, before.name(), &v1::Object::name);
  ASSERT_NE(after, things.end());
  EXPECT_LT((PlaceOf(*after) - PlaceOf(before) - kPush).norm(), kMaxMiss_m);
  // It stays there.
  const std::int64_t at_rest = revision_;
  changes_ = {};
  ProcessUntil(9);
  EXPECT_EQ(revision_, at_rest);
}

INSTANTIATE_TEST_SUITE_P(Calibrations, SeveralSensorsTest, ::testing::ValuesIn(kCalibrationErrors),
                         [](const auto& test) {
                           return std::to_string(std::lround(1000 * test.param.shift_m)) + "mm";
                         });

}  // namespace
}  // namespace cwm::server
