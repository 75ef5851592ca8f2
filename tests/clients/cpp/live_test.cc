// Running sensors and robots of the C++ client with a real server.
#include "cwm/live.h"

#include <gmock/gmock.h>

#include <chrono>
#include <thread>
#include <vector>

#include "tests/clients/cpp/running_server.h"
#include "tests/e2e/two_link_arm.h"

namespace cwm::testing {
namespace {

using std::chrono::milliseconds;
using std::chrono::system_clock;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr int kWidth = 160, kHeight = 120;
constexpr std::size_t kPixels = std::size_t{kWidth} * kHeight;
constexpr milliseconds kFrameTime(33);

// A camera 1 m above the floor that looks straight down.
SensorCalibration DownwardCamera() {
  Eigen::Isometry3d X_WS = At(0, 0, 1);
  X_WS.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  return {.sensor = "overhead",
          .width = kWidth,
          .height = kHeight,
          .pinhole = {.fx_px = 140, .fy_px = 140, .cx_px = 79.5, .cy_px = 59.5},
          .X_WS = X_WS};
}

// The floor with a block of 10 cm on it, in millimetres.
std::vector<std::uint16_t> Depths() {
  std::vector<std::uint16_t> depths(kPixels, 1000);
  for (std::size_t v = 50; v < 70; ++v) {
    for (std::size_t u = 70; u < 90; ++u) depths[v * kWidth + u] = 900;
  }
  return depths;
}

class LiveWorlds : public ClientTest {
 protected:
  World world_ = Connect();
  const Time begin_ = system_clock::now();
};

std::int64_t SumOf(const PixelCounts& pixels) {
  return pixels.consistent + pixels.nearer + pixels.farther + pixels.missing + pixels.robot +
         pixels.carried + pixels.mixed + pixels.hidden;
}

TEST_F(LiveWorlds, AnswerEachFrameOfASensor) {
  SensorStream stream = world_.StreamSensor(DownwardCamera());
  for (int i = 0; i < 3; ++i) {
    const Time stamp = begin_ + i * kFrameTime;
    const FrameResult result = stream.Process(Depths(), {.stamp = stamp});
    EXPECT_EQ(result.frame, i);
    EXPECT_EQ(result.sequence_number, i + 1);
    EXPECT_EQ(result.stamp, stamp);
    EXPECT_EQ(result.fate, FrameFate::kProcessed) << result.reason << ": " << result.message;
    EXPECT_EQ(SumOf(result.pixels), kWidth * kHeight);
    EXPECT_TRUE(result.X_WS.isApprox(*DownwardCamera().X_WS));
    EXPECT_EQ(result.world_uid, world_.uid());
    EXPECT_FALSE(result.stages_ms.empty());
  }
  stream.Finish();
  EXPECT_EQ(stream.Next(), std::nullopt);
  const std::vector<Sensor> sensors = world_.Sensors();
  ASSERT_EQ(sensors.size(), 1U);
  EXPECT_EQ(sensors[0].name, "overhead");
  EXPECT_EQ(sensors[0].processed_count, 3);
  EXPECT_EQ(sensors[0].last_frame, begin_ + 2 * kFrameTime);
  EXPECT_TRUE(sensors[0].X_WS.isApprox(*DownwardCamera().X_WS));
}

TEST_F(LiveWorlds, AnswerFramesOfOneThreadToAnother) {
  SensorCalibration calibration = DownwardCamera();
  calibration.depth_type = DepthType::kF32;
  SensorStream stream = world_.StreamSensor(calibration);
  constexpr int kFrames = 20;
  std::thread sender([&] {
    const std::vector<float> depths(kPixels, 1.0F);
    for (int i = 0; i < kFrames; ++i) stream.Send(depths, {.stamp = begin_ + i * kFrameTime});
    stream.Finish();
  });
  std::int64_t answers = 0, processed = 0;
  while (const auto result = stream.Next()) {
    EXPECT_EQ(result->frame, answers++);
    EXPECT_NE(result->fate, FrameFate::kRefused) << result->reason;
    processed += result->fate == FrameFate::kProcessed ? 1 : 0;
  }
  sender.join();
  EXPECT_EQ(answers, kFrames);
  EXPECT_GE(processed, 1) << "the last frame waits for none";
}

TEST_F(LiveWorlds, RefuseLateFramesAndGoOn) {
  SensorStream stream = world_.StreamSensor(DownwardCamera());
  EXPECT_EQ(stream.Process(Depths(), {.stamp = begin_}).fate, FrameFate::kProcessed);
  const FrameResult late = stream.Process(Depths(), {.stamp = begin_ - kFrameTime});
  EXPECT_EQ(late.fate, FrameFate::kRefused);
  EXPECT_EQ(late.reason, "STALE_FRAME");
  EXPECT_FALSE(late.message.empty());
  EXPECT_EQ(stream.Process(Depths(), {.stamp = begin_ + kFrameTime}).fate, FrameFate::kProcessed);
}

TEST_F(LiveWorlds, RefuseImagesUnlikeTheCalibrationBeforeTheyAreSent) {
  SensorStream stream = world_.StreamSensor(DownwardCamera());
  const Error size =
      ErrorOf([&] { stream.Send(std::vector<std::uint16_t>(7), {.stamp = begin_}); });
  EXPECT_EQ(size.code(), ErrorCode::kInvalidArgument);
  EXPECT_THAT(size.what(), HasSubstr("depths: are 7, must be 19200"));
  const Error type =
      ErrorOf([&] { stream.Send(std::vector<float>(kPixels, 1.0F), {.stamp = begin_}); });
  EXPECT_THAT(type.what(), HasSubstr("must be of calibration.depth_type"));
  SensorCalibration empty = DownwardCamera();
  empty.width = 0;
  EXPECT_THAT(ErrorOf([&] { world_.StreamSensor(empty); }).what(), HasSubstr("must be positive"));
}

TEST_F(LiveWorlds, ThrowTheServersReasonOfAStreamThatEnded) {
  SensorCalibration no_focal_length = DownwardCamera();
  no_focal_length.pinhole.fx_px = 0;
  SensorStream refused = world_.StreamSensor(no_focal_length);
  const Error error = ErrorOf([&] { refused.Process(Depths(), {.stamp = begin_}); });
  EXPECT_EQ(error.code(), ErrorCode::kInvalidArgument);
  EXPECT_THAT(error.what(), HasSubstr("fx_px"));

  SensorCalibration mounted = DownwardCamera();
  mounted.X_WS.reset();
  mounted.mount = SensorMount{.robot = "nobody", .link = "hand"};
  SensorStream nowhere = world_.StreamSensor(mounted);
  EXPECT_EQ(ErrorOf([&] { nowhere.Next(); }).reason(), "ROBOT_UNKNOWN");

  SensorStream deleted = world_.StreamSensor(DownwardCamera());
  deleted.Process(Depths(), {.stamp = begin_});
  world_.server().DeleteWorld(world_.name());
  EXPECT_EQ(ErrorOf([&] { deleted.Next(); }).code(), ErrorCode::kNotFound);
}

TEST_F(LiveWorlds, EndStreamsThatAreClosed) {
  SensorStream stream = world_.StreamSensor(DownwardCamera());
  std::thread closer([&] { stream.Close(); });
  EXPECT_EQ(stream.Next(), std::nullopt);
  closer.join();
}

TEST_F(LiveWorlds, SetThePoseOfASensor) {
  EXPECT_EQ(ErrorOf([&] { world_.SetSensorPose("overhead", At(0, 0, 1)); }).code(),
            ErrorCode::kNotFound);
  SensorStream stream = world_.StreamSensor(DownwardCamera());
  stream.Process(Depths(), {.stamp = begin_});
  Eigen::Isometry3d X_WS = *DownwardCamera().X_WS;
  X_WS.translation().x() = 0.01;
  EXPECT_TRUE(world_.SetSensorPose("overhead", X_WS).isApprox(X_WS));
  EXPECT_TRUE(stream.Process(Depths(), {.stamp = begin_ + kFrameTime}).X_WS.isApprox(X_WS));
}

TEST_F(LiveWorlds, TakeStatesOfARobot) {
  world_.LoadRobot({.urdf = kTwoLinkArm});
  RobotStateStream stream = world_.StreamRobotStates("arm");
  stream.Send(begin_, Eigen::Vector2d(0.1, 0.2));
  const std::vector<Time> stamps = {begin_ + milliseconds(10), begin_ + milliseconds(20)};
  stream.Send(stamps, (Eigen::Matrix2d() << 0.2, 0.3, 0.2, 0.25).finished());
  stream.Send(begin_, Eigen::Vector2d(0.1, 0.2));  // once more
  const RobotStatesSummary summary = stream.Finish();
  EXPECT_EQ(summary.state_count + summary.ignored_count, 4);
  EXPECT_GE(summary.state_count, 3);
  EXPECT_EQ(summary.world_uid, world_.uid());
}

TEST_F(LiveWorlds, RefuseStatesThatFitNoRobot) {
  world_.LoadRobot({.urdf = kTwoLinkArm});
  RobotStateStream unknown = world_.StreamRobotStates("nobody");
  EXPECT_EQ(ErrorOf([&] { unknown.Finish(); }).reason(), "ROBOT_UNKNOWN");
  RobotStateStream wide = world_.StreamRobotStates("arm");
  EXPECT_EQ(ErrorOf([&] {
              wide.Send(begin_, Eigen::Vector3d::Zero());
              wide.Finish();
            }).code(),
            ErrorCode::kInvalidArgument);
  RobotStateStream stream = world_.StreamRobotStates("arm");
  const std::vector<Time> two = {begin_, begin_ + kFrameTime};
  EXPECT_THAT(ErrorOf([&] { stream.Send(two, Eigen::MatrixXd::Zero(2, 3)); }).what(),
              HasSubstr("values: has 3 columns, must have 2"));
  EXPECT_THAT(ErrorOf([&] {
                stream.Send(two, Eigen::MatrixXd::Zero(2, 2), std::vector(1, At(0, 0, 0)));
              }).what(),
              HasSubstr("X_WB: are 1, must be 2"));
  EXPECT_THAT(world_.Sensors(), IsEmpty());
}

}  // namespace
}  // namespace cwm::testing
