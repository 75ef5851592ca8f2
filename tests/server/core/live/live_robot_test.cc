// A box that a robot lifts before a wall, seen by a depth camera: closed forms of what each pixel
// shows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <thread>

#include "server/core/live/live_world.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::server {
namespace {

using perception::PixelClass;
using perception::Stamp;
using std::chrono::milliseconds;
using ::testing::HasSubstr;

constexpr Stamp kBegin{std::chrono::hours(400'000)};
constexpr int kWidth = 64, kHeight = 48;
constexpr double kWall_m = 1.5, kFront_m = 0.9, kHalf_m = 0.1;

// A cube with edges of 0.2 m on a vertical slide, 1 m before the camera.
constexpr char kLift[] =
    "<robot name='arm'><link name='base'/><link name='hand'><collision><geometry>"
    "<box size='0.2 0.2 0.2'/></geometry></collision></link>"
    "<joint name='lift' type='prismatic'><parent link='base'/><child link='hand'/>"
    "<axis xyz='0 0 1'/><limit lower='0' upper='2'/></joint></robot>";

// At 1 m above the origin, looking along x.
Pose CameraPose() {
  Pose X_WC = MakeTranslation(0, 0, 1);
  X_WC.linear().col(0) = -Vector3::UnitY();
  X_WC.linear().col(1) = -Vector3::UnitZ();
  X_WC.linear().col(2) = Vector3::UnitX();
  return X_WC;
}

// What the camera sees with the cube's centre at this height; no height: no cube.
LiveFrame FrameAt(Stamp stamp, std::optional<double> lift_m) {
  LiveFrame frame;
  frame.stamp = stamp;
  frame.camera = {.pinhole = {.focal_u_px = kWidth,
                              .focal_v_px = kWidth,
                              .center_u_px = 0.5 * (kWidth - 1),
                              .center_v_px = 0.5 * (kHeight - 1)},
                  .width = kWidth,
                  .height = kHeight};
  auto image = std::make_shared<perception::DepthImage>();
  image->width = kWidth;
  image->height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double y_m = -kFront_m * (u - 0.5 * (kWidth - 1)) / kWidth;
      const double z_m = 1 - kFront_m * (v - 0.5 * (kHeight - 1)) / kWidth;
      const bool on_cube =
          lift_m.has_value() && std::abs(y_m) <= kHalf_m && std::abs(z_m - *lift_m) <= kHalf_m;
      image->depth_m.push_back(static_cast<float>(on_cube ? kFront_m : kWall_m));
    }
  }
  frame.image = std::move(image);
  frame.received = frame.begun = frame.decoded = Clock::now();
  return frame;
}

class LiveRobotTest : public ::testing::Test {
 protected:
  LiveRobotTest() {
    collision::PutRobot put =
        collision::testing::PutArm("arm", collision::testing::Arm(kLift, "<robot name='arm'/>"));
    put.X_WB = MakeTranslation(1, 0, 0);
    const auto applied =
        world_->Apply(std::vector{collision::testing::MakeChange(std::move(put))}, {});
    EXPECT_TRUE(applied.ok()) << applied.status();
  }

  void Open(const SensorCalibration& calibration) {
    auto opened = live_->Open(calibration, {});
    ASSERT_TRUE(opened.ok()) << opened.status();
    stream_ = *std::move(opened);
    while (!live_->PrepareRobots()) std::this_thread::sleep_for(milliseconds(1));
  }
  void OpenFixed() {
    SensorCalibration calibration{.sensor = "head"};
    calibration.X_WC = CameraPose();
    Open(calibration);
  }
  void Tell(int at_ms, double lift_m) {
    const StampedRobotState state{.stamp = kBegin + milliseconds(at_ms), .values = {lift_m}};
    const auto robot = world_->Snapshot()->FindRobot("arm");
    const int variables[] = {0};
    const auto added = world_->robot_states().Add(*robot, variables, {&state, 1}, state.stamp);
    EXPECT_TRUE(added.ok()) << added.status();
  }
  FrameOutcome Process(int at_ms, std::optional<double> lift_m) {
    auto outcome = stream_->Process(FrameAt(kBegin + milliseconds(at_ms), lift_m));
    EXPECT_TRUE(outcome.ok()) << outcome.status();
    return outcome.ok() ? *std::move(outcome) : FrameOutcome();
  }
  static std::int64_t CountOf(const FrameOutcome& outcome, PixelClass of) {
    return outcome.pixels[static_cast<std::size_t>(of)];
  }

  const std::shared_ptr<World> world_ = std::make_shared<World>("w", "uid", Retention{});
  const std::shared_ptr<LiveWorld> live_ = std::make_shared<LiveWorld>(
      world_, LiveServices{.interpret =
                               [](const auto&, const auto&, std::stop_token) {
                                 return absl::UnimplementedError("no interpreter");
                               },
                           .run_beside = [](const std::function<void()>&) { return false; }});
  std::unique_ptr<SensorStream> stream_;
};

// The cube covers 14 x 14 pixels.
constexpr int kMinCubePixels = 180;

TEST_F(LiveRobotTest, ItsPixelsAreTheRobotsAndItsStateBecomesTheWorlds) {
  OpenFixed();
  for (int k = 0; k < 8; ++k) {
    const double lift_m = 1 + 0.01 * k;
    Tell(40 * k, lift_m);
    const FrameOutcome outcome = Process(40 * k, lift_m);
    EXPECT_EQ(outcome.reason, "");
    EXPECT_EQ(outcome.robot_state_age_ms, 0);
    EXPECT_GE(CountOf(outcome, PixelClass::kRobot), kMinCubePixels);
    EXPECT_TRUE(outcome.changes.movers.empty());
    EXPECT_EQ(world_->Snapshot()->FindRobot("arm")->state[0], lift_m);
  }
}

TEST_F(LiveRobotTest, AFrameBetweenTwoStatesUsesTheStateOfItsStamp) {
  OpenFixed();
  Tell(0, 0.8);
  Tell(100, 1.2);
  const FrameOutcome outcome = Process(50, 1.0);
  EXPECT_EQ(outcome.reason, "");
  EXPECT_GE(CountOf(outcome, PixelClass::kRobot), kMinCubePixels);
}

TEST_F(LiveRobotTest, StatesThatAreMissingOrStaleAreTold) {
  OpenFixed();
  EXPECT_EQ(Process(0, 1.0).reason, "ROBOT_STATE_MISSING");
  Tell(100, 1.0);
  EXPECT_EQ(Process(100, 1.0).reason, "");
  const FrameOutcome late = Process(400, 1.0);
  EXPECT_EQ(late.reason, "ROBOT_STATE_STALE");
  EXPECT_THAT(late.message, HasSubstr("state of the robot \"arm\" is 300 ms older"));
  EXPECT_NEAR(late.robot_state_age_ms.value_or(0), 300, 1e-6);
  EXPECT_EQ(late.fate, FrameFate::kProcessed);
  Tell(700, 1.2);
  const FrameOutcome between = Process(500, 1.0);
  EXPECT_EQ(between.reason, "ROBOT_STATE_STALE");
  EXPECT_THAT(between.message, HasSubstr("must be at most 200 ms apart"));
}

TEST_F(LiveRobotTest, AStateThatTheRaysContradictIsTold) {
  OpenFixed();
  Tell(0, 0.8);
  const FrameOutcome outcome = Process(0, std::nullopt);
  EXPECT_EQ(outcome.reason, "ROBOT_STATE_WRONG");
  EXPECT_THAT(outcome.message, HasSubstr("arm/hand"));
}

TEST_F(LiveRobotTest, AStateThatSomebodySetIsThatOfTheRobotUntilStatesAreTold) {
  OpenFixed();
  const auto set =
      world_->Apply(std::vector{collision::testing::MakeChange(collision::SetRobotState{
                        .name = "arm",
                        .X_WB = std::nullopt,
                        .joints = {.named = {}, .values = {{"lift", 1.0}}}})},
                    {});
  ASSERT_TRUE(set.ok()) << set.status();
  const FrameOutcome outcome = Process(0, 1.0);
  EXPECT_EQ(outcome.reason, "");
  EXPECT_EQ(outcome.robot_state_age_ms, std::nullopt);
  EXPECT_GE(CountOf(outcome, PixelClass::kRobot), kMinCubePixels);
}

TEST_F(LiveRobotTest, ASensorOnALinkIsWhereTheLinkWasAtTheStamp) {
  SensorCalibration calibration{.sensor = "wrist"};
  calibration.mount =
      SensorMount{.robot = "arm", .link = "hand", .X_LC = MakeTranslation(0, 0, 0.5)};
  Open(calibration);
  EXPECT_EQ(Process(0, std::nullopt).fate, FrameFate::kRefused);
  Tell(100, 1.0);
  Tell(200, 1.2);
  const FrameOutcome outcome = Process(150, std::nullopt);
  EXPECT_EQ(outcome.fate, FrameFate::kProcessed);
  EXPECT_TRUE(outcome.X_WC.translation().isApprox(Vector3(1, 0, 1.1 + 0.5), 1e-9));
  const FrameOutcome late = Process(260, std::nullopt);
  EXPECT_EQ(late.reason, "ROBOT_STATE_STALE");
  EXPECT_THAT(late.message, HasSubstr("is 60 ms older than the frame, must be at most 20 ms"));
  EXPECT_THAT(late.message, HasSubstr("arm/hand"));
}

TEST_F(LiveRobotTest, WhatItCarriesIsItsOwnAtTheStampsPlace) {
  OpenFixed();
  HybridModel cube;
  cube.shapes.push_back({.X_OS = Pose::Identity(), .shape = Box{Vector3::Constant(0.2)}});
  const auto put = world_->Apply(
      std::vector{
          collision::testing::MakeChange(collision::PutObject{
              .name = "load",
              .X_WO = MakeTranslation(1, 0.2, 0),
              .geometry = collision::Prepare(std::make_shared<const HybridModel>(cube)),
              .supported_by = {}}),
          collision::testing::MakeChange(collision::AttachObject{
              .name = "load", .robot = "arm", .link = "hand", .X_LO = MakeTranslation(0, 0.2, 0)})},
      {});
  ASSERT_TRUE(put.ok()) << put.status();
  Tell(0, 1.0);
  LiveFrame frame = FrameAt(kBegin, 1.0);
  auto image = std::make_shared<perception::DepthImage>(*frame.image);
  int load_px = 0;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const double y_m = -kFront_m * (u - 0.5 * (kWidth - 1)) / kWidth;
      const double z_m = 1 - kFront_m * (v - 0.5 * (kHeight - 1)) / kWidth;
      if (y_m < kHalf_m || y_m > 3 * kHalf_m || std::abs(z_m - 1) > kHalf_m) continue;
      image->depth_m[static_cast<std::size_t>(v) * kWidth + u] = static_cast<float>(kFront_m);
      ++load_px;
    }
  }
  frame.image = image;
  const auto outcome = stream_->Process(frame);
  ASSERT_TRUE(outcome.ok()) << outcome.status();
  EXPECT_GT(load_px, 100);
  // Those within the hand's own margin of 20 mm may be the hand's.
  EXPECT_GT(CountOf(*outcome, PixelClass::kCarried), load_px / 2);
}

}  // namespace
}  // namespace cwm::server
