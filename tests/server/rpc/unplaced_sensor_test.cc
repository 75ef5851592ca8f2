// Streams of sensors whose pose nobody tells.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "server/core/live/first_frame.h"
#include "tests/server/rpc/depth_stream.h"
#include "tests/server/rpc/simulated_depth.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double kStart_s = 1'700'000'000;

class UnplacedSensorTest : public RunningServer {
 protected:
  v1::SensorCalibration Calibration() const {
    v1::SensorCalibration calibration;
    calibration.set_sensor("head");
    *calibration.mutable_depth() = camera_.Layout();
    return calibration;
  }
  v1::SensorFrame Frame(double after_s, std::uint64_t seed = 1) const {
    v1::SensorFrame frame;
    frame.mutable_frame_stamp()->set_seconds(static_cast<std::int64_t>(kStart_s));
    frame.mutable_frame_stamp()->set_nanos(static_cast<std::int32_t>(1e9 * after_s));
    frame.set_depth(camera_.Frame(seed));
    return frame;
  }
  v1::StreamCloudsResponse Answer(const v1::SensorFrame& frame) {
    EXPECT_TRUE(stream_.Send(frame));
    const auto answer = stream_.Next();
    EXPECT_TRUE(answer.has_value());
    return answer.value_or(v1::StreamCloudsResponse());
  }

  SimulatedDepth camera_;
  DepthStream stream_{*perception_};
};

TEST_F(UnplacedSensorTest, TheFirstFrameTellsThePoseAndIsInterpreted) {
  ASSERT_TRUE(stream_.Send(Calibration()));
  const v1::StreamCloudsResponse first = stream_.MustProcess(Frame(0));
  EXPECT_THAT(first.changes().added(), Not(IsEmpty()));
  EXPECT_EQ(first.revision(), 1);
  // The estimate has its origin at the sensor, and looks down at the counter.
  EXPECT_EQ(first.x_world_sensor().tx_m(), 0);
  EXPECT_EQ(first.x_world_sensor().tz_m(), 0);
  EXPECT_GT(first.pixels().consistent(), 8 * camera_.pixel_count() / 10);
  double interpreted_ms = 0;
  for (const v1::StageTime& stage : first.stages()) {
    if (stage.stage() == "interpret") interpreted_ms = stage.elapsed_ms();
  }
  EXPECT_GT(interpreted_ms, 1);
  for (int k = 1; k < 6; ++k) {
    const v1::StreamCloudsResponse next =
        stream_.MustProcess(Frame(0.1 * k, static_cast<std::uint64_t>(k)));
    EXPECT_EQ(next.revision(), 1) << "nothing changed";
    EXPECT_EQ(next.x_world_sensor().qx(), first.x_world_sensor().qx());
  }
  EXPECT_TRUE(stream_.Finish().ok());
  // The estimate serves scans, and a later stream.
  DepthStream again(*perception_);
  ASSERT_TRUE(again.Send(Calibration()));
  const v1::StreamCloudsResponse later = again.MustProcess(Frame(0.9));
  EXPECT_EQ(later.x_world_sensor().qx(), first.x_world_sensor().qx());
  for (const v1::StageTime& stage : later.stages()) EXPECT_NE(stage.stage(), "interpret");
}

TEST_F(UnplacedSensorTest, AFrameThatConfirmsNoEstimateIsRefusedAndALaterOneTries) {
  v1::SensorCalibration calibration = Calibration();
  ASSERT_TRUE(stream_.Send(calibration));
  v1::SensorFrame wall = WallFrame(calibration, 1.5F, kStart_s);
  const v1::StreamCloudsResponse refused = Answer(wall);
  EXPECT_EQ(refused.fate(), v1::FRAME_FATE_REFUSED);
  EXPECT_EQ(refused.reason(), "SENSOR_POSE_UNKNOWN");
  EXPECT_THAT(refused.message(), HasSubstr("Give the pose"));
  EXPECT_EQ(refused.revision(), 0) << "nothing was written";
  // Soon after, no other frame is interpreted.
  const auto begin = Clock::now();
  const v1::StreamCloudsResponse soon = Answer(Frame(0.1));
  if (Clock::now() - begin < kFirstFramePeriod / 2) {
    EXPECT_EQ(soon.reason(), "SENSOR_POSE_UNKNOWN");
  }
  std::this_thread::sleep_for(kFirstFramePeriod);
  EXPECT_EQ(stream_.MustProcess(Frame(0.2)).revision(), 1);
}

TEST_F(UnplacedSensorTest, AFrameThatCannotBeInterpretedIsRefusedWithTheErrorOfScans) {
  ASSERT_TRUE(stream_.Send(Calibration()));
  v1::SensorFrame empty = Frame(0);
  empty.set_depth(std::string(empty.depth().size(), '\0'));
  const v1::StreamCloudsResponse refused = Answer(empty);
  EXPECT_EQ(refused.fate(), v1::FRAME_FATE_REFUSED);
  EXPECT_THAT(refused.reason(), Not(IsEmpty()));
  EXPECT_THAT(refused.message(), HasSubstr("finite"));
}

TEST_F(UnplacedSensorTest, APoseThatIsToldMeanwhileIsTaken) {
  v1::SensorCalibration calibration = Calibration();
  ASSERT_TRUE(stream_.Send(calibration));
  Answer(WallFrame(calibration, 1.5F, kStart_s));
  v1::SetSensorPoseRequest set;
  set.set_sensor("head");
  set.mutable_x_world_sensor()->set_tz_m(2);
  set.mutable_x_world_sensor()->set_qx(1);
  Call call;
  v1::SetSensorPoseResponse response;
  ASSERT_TRUE(perception_->SetSensorPose(&call, set, &response).ok());
  EXPECT_EQ(stream_.MustProcess(Frame(0.5)).x_world_sensor().tz_m(), 2);
}

}  // namespace
}  // namespace cwm::server
