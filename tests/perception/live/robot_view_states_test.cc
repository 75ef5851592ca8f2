// The pixels of robots whose state is late, missing or wrong.
#include "perception/live/robot_view.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/perception/live/seen_robot.h"

namespace cwm::perception {
namespace {

TEST(RobotView, WidensMarginsBySpeedAndLateness) {
  SeenRobot view;
  view.Take();
  std::vector<LinkAtStamp> late = view.robot.poses;
  for (LinkAtStamp& link : late) {
    link.X_WL.translation().x() -= 0.04;
    link.V_WL.linear_W_m_s = {1, 0, 0};
  }
  const auto left = [&](const RobotSighting& sighting) {
    int count = 0;
    for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
      if (view.ShowsRobot(pixel) && At(sighting, pixel) == 0) ++count;
    }
    return count;
  };
  view.margins.clock_s = 0;
  EXPECT_GT(left(view.Mask(late)), 100);
  view.source = StateSource::kHeld;
  view.late_s = 0.02;  // 20 mm more
  EXPECT_EQ(left(view.Mask(late)), 0);
  view.late_s = 0;
  view.margins.exposure_s = 0.04;
  EXPECT_EQ(left(view.Mask(late)), 0);
}

TEST(RobotView, TellsAWrongStateByRaysThroughALinkAndTakesNothingAway) {
  SeenRobot view;
  view.Take();
  std::vector<LinkAtStamp> wrong = view.robot.poses;
  wrong[2].X_WL.translation() += Vector3(0.06, 0.05, 0);
  const RobotSighting sighting = view.Mask(wrong);
  EXPECT_EQ(sighting.fault, RobotStateFault::kWrong);
  EXPECT_EQ(sighting.through_link, 2);
  EXPECT_GT(sighting.through_share, 0.1);
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    // The robot is not left in the world, and what is behind is where it was.
    if (view.ShowsRobot(pixel)) {
      EXPECT_NE(At(sighting, pixel), 0);
    } else if (view.truth.pixels[pixel].seen() && view.RobotDistance_m(pixel) > 0.2) {
      EXPECT_EQ(At(sighting, pixel), 0);
    }
  }
  // The table vanishes below the arm while nobody knows where the arm is: nothing is told.
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (!view.ShowsRobot(pixel)) view.image.depth_m[pixel] += 0.1F;
  }
  const RobotSighting behind = view.Mask(wrong);
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.truth.pixels[pixel].seen() && view.IsNearRobot(pixel, 8)) {
      EXPECT_NE(At(behind, pixel), 0);
    }
  }
}

TEST(RobotView, ARightStateIsNotToldWrongWithinItsMargin) {
  SeenRobot view;
  view.Take();
  for (const Vector3& shift : {Vector3(0.018, 0, 0), Vector3(0, -0.018, 0), Vector3(0, 0, 0.018)}) {
    std::vector<LinkAtStamp> poses = view.robot.poses;
    for (LinkAtStamp& link : poses) link.X_WL.translation() += shift;
    const RobotSighting sighting = view.Mask(poses);
    EXPECT_EQ(sighting.fault, RobotStateFault::kNone);
    EXPECT_EQ(sighting.through_pixels, 0);
    for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
      if (view.ShowsRobot(pixel)) {
        EXPECT_EQ(At(sighting, pixel), kRobotByte);
      }
    }
  }
}

TEST(RobotView, WithoutAStateNothingUnknownIsTakenWithinReach) {
  SeenRobot view;
  view.Take();
  view.source = StateSource::kMissing;
  const DepthCamera camera = view.scene.camera();
  RobotView robots(view.robot.Surface());
  const RobotFrame frame{.camera = &camera,
                         .X_WC = view.scene.pinhole.X_WC,
                         .image = &view.image,
                         .noise = FineNoise(),
                         .expected_m = view.expected_m};
  const RobotSighting sighting =
      robots.Mask(frame, {.reach_W = {{0, 0, 0.5}, 0.5}}, {}, view.margins);
  EXPECT_EQ(sighting.fault, RobotStateFault::kMissing);
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    EXPECT_EQ(At(sighting, pixel), view.ShowsRobot(pixel) ? kMixedByte : 0);
  }
  // A known surface within reach is seen, one that is not where it was is not told.
  RobotFrame unknown = frame;
  unknown.expected_m = {};
  const RobotSighting all = robots.Mask(unknown, {.reach_W = {{0, 0, 0.5}, 0.8}}, {}, {});
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (!view.truth.pixels[pixel].seen()) continue;
    const double distance_m = (view.Point(pixel) - Vector3(0, 0, 0.5)).norm();
    if (distance_m < 0.799) {
      EXPECT_EQ(At(all, pixel), kMixedByte);
    }
    if (distance_m > 1 && !view.IsNearRobot(pixel, 4)) {
      EXPECT_EQ(At(all, pixel), 0);
    }
  }
  // Without a bound, the robot may be anywhere.
  EXPECT_GT(CountOf(robots.Mask(unknown, {}, {}, {}), kMixedByte), CountOf(all, kMixedByte));
}

TEST(VelocityBetween, TakesAFrameFromOnePoseToTheOther) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20; ++i) {
    const Pose X_before = RandomPose(random, 1), X_after = RandomPose(random, 1);
    const SpatialVelocity V = VelocityBetween(X_before, X_after, 0.5);
    const Vector3 turn = 0.5 * V.angular_W_rad_s;
    const Matrix3 R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    EXPECT_TRUE((R * X_before.linear()).isApprox(X_after.linear(), 1e-9));
    EXPECT_TRUE(
        (X_before.translation() + 0.5 * V.linear_W_m_s).isApprox(X_after.translation(), 1e-9));
  }
  const SpatialVelocity still = VelocityBetween(Pose::Identity(), Pose::Identity(), 0.1);
  EXPECT_EQ(still.angular_W_rad_s.norm(), 0);
}

}  // namespace
}  // namespace cwm::perception
