// The pixels of robots, and those of what is around them.
#include "perception/live/robot_view.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/perception/live/seen_robot.h"

namespace cwm::perception {
namespace {

TEST(RobotView, TellsEveryPixelOfTheRobotAndNoOther) {
  SeenRobot view;
  view.Take();
  const RobotSighting sighting = view.Mask();
  int robot = 0;
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    const std::uint8_t expected = view.ShowsRobot(pixel) ? kRobotByte : std::uint8_t{0};
    EXPECT_EQ(At(sighting, pixel), expected) << pixel;
    robot += view.ShowsRobot(pixel) ? 1 : 0;
  }
  EXPECT_GT(robot, 2000);
  EXPECT_EQ(sighting.fault, RobotStateFault::kNone);
  EXPECT_EQ(sighting.through_pixels, 0);
}

TEST(RobotView, ClaimsPointsByTheirDistanceIfNothingIsKnown) {
  SeenRobot view;
  view.with_expected = false;
  view.robot.poses[0].X_WL = MakeTranslation(0, 0, 0.21);  // the foot 10 mm above the table
  view.Take();
  const RobotSighting sighting = view.Mask();
  const double margin_m = 0.02 + 3 * 0.001;
  int near_table = 0;
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (!view.truth.pixels[pixel].seen()) continue;
    const double distance_m = view.RobotDistance_m(pixel);
    if (std::abs(distance_m - margin_m) < 0.001) continue;  // round shapes are approximated
    EXPECT_EQ(At(sighting, pixel) == kRobotByte, distance_m < margin_m) << distance_m;
    if (!view.ShowsRobot(pixel) && distance_m < margin_m) ++near_table;
  }
  EXPECT_GT(near_table, 20);
}

TEST(RobotView, LeavesKnownThingsBesideARobotAlone) {
  SeenRobot view;
  // A can 12 mm before the forearm's end, and the foot 10 mm above the table.
  view.robot.poses[0].X_WL = MakeTranslation(0, 0, 0.21);
  view.scene.things.objects.push_back(
      {.name = "can",
       .parts = {{Pose::Identity(), Cylinder{.radius_m = 0.04, .length_m = 0.8}}},
       .X_WO = MakeTranslation(0.27 + 0.012 + 0.04, 0, 0.4)});
  view.Take();
  int kept = 0, shown = 0, swallowed = 0;
  const RobotSighting sighting = view.Mask();
  view.with_expected = false;
  const RobotSighting blind = view.Mask();
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.ShowsRobot(pixel)) {
      EXPECT_EQ(At(sighting, pixel), kRobotByte);
    } else if (view.truth.pixels[pixel].seen() && view.RobotDistance_m(pixel) < 0.03) {
      ++shown;
      if (At(sighting, pixel) == 0) ++kept;
      if (At(blind, pixel) != 0) ++swallowed;
    }
  }
  EXPECT_GT(shown, 100);
  EXPECT_EQ(kept, shown);
  EXPECT_GT(swallowed, shown / 4);  // what knowing them is for
}

TEST(RobotView, TakesDepthsBetweenTheRobotAndWhatIsBehindForMixed) {
  SeenRobot view;
  view.Take();
  const std::vector<float> expected_m = view.expected_m;
  const DepthImage clean = view.image;
  int beside = 0, far_from_it = 0;
  // Every other pixel that shows the table gets a depth half way to the camera's foreground.
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); pixel += 2) {
    if (view.truth.pixels[pixel].object != 0) continue;
    if (view.RobotDistance_m(pixel) < 0.2) continue;
    view.image.depth_m[pixel] -= 0.08F;
  }
  const RobotSighting sighting = view.Mask();
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.image.depth_m[pixel] == clean.depth_m[pixel]) continue;
    if (view.RobotDistance_m(pixel) < 0.03) continue;
    if (view.IsNearRobot(pixel, 2)) {
      EXPECT_EQ(At(sighting, pixel), kMixedByte);
      ++beside;
    } else if (!view.IsNearRobot(pixel, 4)) {
      EXPECT_EQ(At(sighting, pixel), 0);
      ++far_from_it;
    }
  }
  EXPECT_GT(beside, 100);
  EXPECT_GT(far_from_it, 1000);
}

TEST(RobotView, LeavesWhatIsBeforeTheRobotAlone) {
  SeenRobot view;
  view.Take();
  for (float& depth_m : view.image.depth_m) depth_m = 0.4F;  // a wall 0.4 m before the camera
  EXPECT_TRUE(view.Mask().mask.empty());
}

TEST(RobotView, HidesKnownSurfacesWhereTheRobotGivesNoReturn) {
  SeenRobot view;
  view.Take();
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.ShowsRobot(pixel)) view.image.depth_m[pixel] = 0;
  }
  const RobotSighting sighting = view.Mask();
  std::int64_t robot = 0;
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.ShowsRobot(pixel) && std::isfinite(view.expected_m[pixel])) ++robot;
    if (!view.IsNearRobot(pixel, 2)) {
      EXPECT_EQ(At(sighting, pixel), 0);
    }
  }
  EXPECT_NEAR(static_cast<double>(CountOf(sighting, kHiddenByte)), static_cast<double>(robot),
              0.05 * static_cast<double>(robot));
  // A known surface before the robot is missing, not hidden.
  std::fill(view.expected_m.begin(), view.expected_m.end(), 0.3F);
  EXPECT_EQ(CountOf(view.Mask(), kHiddenByte), 0);
  view.with_expected = false;
  EXPECT_GE(CountOf(view.Mask(), kHiddenByte), CountOf(sighting, kHiddenByte));
}

TEST(RobotView, TellsWhatIsCarriedFromTheRobot) {
  SeenRobot view;
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.shape = Box{{0.08, 0.08, 0.2}}});
  // It hangs from the forearm's end and touches it.
  const KnownBody box{.id = 7,
                      .kind = KnownBody::Kind::kCarried,
                      .name = "box",
                      .X_WB = MakeTranslation(0.2, 0, 0.68 - 0.1),
                      .model = model};
  view.scene.things.objects.push_back(
      {.name = "box", .parts = {{Pose::Identity(), model->shapes[0].shape}}, .X_WO = box.X_WB});
  view.Take();
  view.expected_m = ExpectedOf(RobotScene().Sightings(nullptr));  // of the table alone
  view.carried = {{.body = &box, .link = 2}};
  const RobotSighting sighting = view.Mask();
  int carried = 0, wrong = 0;
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    const bool is_carried = view.truth.pixels[pixel].object == 1;
    if (is_carried) ++carried;
    if (!is_carried && !view.ShowsRobot(pixel)) {
      EXPECT_EQ(At(sighting, pixel), 0);
    } else if (At(sighting, pixel) != (is_carried ? kCarriedByte : kRobotByte)) {
      ++wrong;
    }
  }
  EXPECT_GT(carried, 300);
  EXPECT_LE(wrong, carried / 100);  // where the two touch
  // Expected bodies that are carried are no reason to leave its pixels alone.
  const DepthCamera camera = view.scene.camera();
  const std::vector<float> expected_m = ExpectedOf(view.scene.Sightings(nullptr));
  const std::vector<BodyId> ids(expected_m.size(), box.id);
  RobotView again(view.robot.Surface());
  const RobotSighting with_ids =
      again.Mask({.camera = &camera,
                  .X_WC = view.scene.pinhole.X_WC,
                  .image = &view.image,
                  .noise = FineNoise(),
                  .expected_m = expected_m,
                  .expected_body = ids},
                 {.source = StateSource::kInterpolated, .links = view.robot.poses}, view.carried,
                 view.margins);
  EXPECT_EQ(CountOf(with_ids, kCarriedByte), CountOf(sighting, kCarriedByte));
}

TEST(RobotView, IsEmptyWithoutARobotInView) {
  SeenRobot view;
  view.Take();
  EXPECT_TRUE(view.Mask({}).mask.empty());  // a robot without links
  std::vector<LinkAtStamp> behind = view.robot.poses;
  for (LinkAtStamp& link : behind) {
    link.X_WL.translation() += 3 * (view.scene.pinhole.X_WC.translation() - Vector3(0, 0, 0.4));
  }
  EXPECT_TRUE(view.Mask(behind).mask.empty());
  std::vector<LinkAtStamp> beside = view.robot.poses;
  for (LinkAtStamp& link : beside) {
    link.X_WL.translation() += 3 * view.scene.pinhole.X_WC.linear().col(0);
  }
  EXPECT_TRUE(view.Mask(beside).mask.empty());
  view.image.depth_m.assign(view.image.depth_m.size(), 0);
  view.with_expected = true;
  view.expected_m.assign(view.expected_m.size(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(CountOf(view.Mask(), kRobotByte), 0);
}

TEST(RobotView, ACameraWithinTheBoundsOfALinkSeesPastIt) {
  SeenRobot view;
  // The camera is inside of the hull of a link, as a camera in a hand's housing is, and sees the
  // arm.
  view.robot.links.push_back({Box{{0.1, 0.1, 0.1}}});
  view.robot.poses.push_back({view.scene.pinhole.X_WC});
  SmallRobot arm = Arm();
  view.truth = view.scene.Sightings(&arm);
  view.image = DepthsOf(view.truth);
  view.expected_m = ExpectedOf(view.scene.Sightings(nullptr));
  const RobotSighting sighting = view.Mask();
  EXPECT_EQ(sighting.fault, RobotStateFault::kNone);
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    EXPECT_EQ(At(sighting, pixel), view.ShowsRobot(pixel) ? kRobotByte : 0);
  }
}

// A camera on a hand looks past two fingers, which reach out of the image and behind the camera.
TEST(RobotView, AWristCameraSeesTheFingersBesideIt) {
  SeenRobot view;
  view.scene.pinhole.X_WC = LookAt(Vector3(0.05, 0, 0.4), Vector3(0, 0, 0));
  const Pose X_WC = view.scene.pinhole.X_WC;
  view.robot.links = {{Box{{0.02, 0.02, 0.24}}}, {Box{{0.02, 0.02, 0.24}}}};
  view.robot.poses = {{X_WC * MakeTranslation(-0.03, 0.01, 0.05)},
                      {X_WC * MakeTranslation(0.04, 0.01, 0.05)}};
  // A ball between the finger tips, 29 mm from them.
  view.scene.things.objects.push_back({.name = "ball",
                                       .parts = {{Pose::Identity(), Sphere{.radius_m = 0.01}}},
                                       .X_WO = X_WC * MakeTranslation(0.005, 0.01, 0.2)});
  view.Take();
  // The hand and its camera move fast, but not one against the other.
  const SpatialVelocity V{.angular_W_rad_s = {0, 0, 2}, .linear_W_m_s = {1, 0, 0}};
  for (LinkAtStamp& link : view.robot.poses) {
    link.V_WL = V;
    link.V_WL.linear_W_m_s += V.angular_W_rad_s.cross(link.X_WL.translation() - X_WC.translation());
  }
  const DepthCamera camera = view.scene.camera();
  RobotView robots(view.robot.Surface());
  RobotFrame frame{
      .camera = &camera, .X_WC = X_WC, .V_WC = V, .image = &view.image, .noise = FineNoise()};
  const RobotAtStamp state{
      .source = StateSource::kExtrapolated, .late_s = 0.05, .links = view.robot.poses};
  const RobotSighting sighting = robots.Mask(frame, state, {}, {});
  int fingers = 0;
  for (std::size_t pixel = 0; pixel < view.truth.pixels.size(); ++pixel) {
    if (view.ShowsRobot(pixel)) {
      ++fingers;
      EXPECT_EQ(At(sighting, pixel), kRobotByte);
    } else if (view.truth.pixels[pixel].seen() && view.RobotDistance_m(pixel) > 0.025) {
      EXPECT_NE(At(sighting, pixel), kRobotByte);
    }
  }
  EXPECT_GT(fingers, 2000);
  // Seen from a camera that stands still, the same fingers may be 50 mm away from there.
  frame.V_WC = {};
  EXPECT_GT(CountOf(robots.Mask(frame, state, {}, {}), kRobotByte), CountOf(sighting, kRobotByte));
}

TEST(RobotView, ResultsFollowFromTheCallAlone) {
  SeenRobot view;
  view.Take();
  const DepthCamera camera = view.scene.camera();
  RobotView robots(view.robot.Surface());
  const RobotFrame frame{.camera = &camera,
                         .X_WC = view.scene.pinhole.X_WC,
                         .image = &view.image,
                         .noise = FineNoise(),
                         .expected_m = view.expected_m};
  const RobotAtStamp state{.source = StateSource::kInterpolated, .links = view.robot.poses};
  const RobotSighting first = robots.Mask(frame, state, {}, {});
  robots.Mask(frame, {.reach_W = {{0, 0, 0.5}, 0.5}}, {}, {});
  EXPECT_EQ(robots.Mask(frame, state, {}, {}).mask.pixels, first.mask.pixels);
}

TEST(RobotView, TheRectangleHoldsAllPixelsOfTheMask) {
  SeenRobot view;
  view.Take();
  const RobotMask mask = view.Mask().mask;
  int u_begin = mask.u_end, v_begin = mask.v_end, u_end = 0, v_end = 0;
  for (int v = 0; v < view.image.height; ++v) {
    for (int u = 0; u < view.image.width; ++u) {
      if (mask.pixels[static_cast<std::size_t>(v) * view.image.width + u] == 0) continue;
      u_begin = std::min(u_begin, u);
      u_end = std::max(u_end, u + 1);
      v_begin = std::min(v_begin, v);
      v_end = std::max(v_end, v + 1);
    }
  }
  EXPECT_EQ(mask.u_begin, u_begin);
  EXPECT_EQ(mask.u_end, u_end);
  EXPECT_EQ(mask.v_begin, v_begin);
  EXPECT_EQ(mask.v_end, v_end);
}

TEST(MergeMask, TakesTheSurerClassOfTwoRobots) {
  const DepthCamera camera{.pinhole = {}, .width = 4, .height = 1};
  RobotMask mask{.pixels = {kRobotByte, kMixedByte, 0, 0}, .u_end = 2, .v_end = 1};
  const RobotMask other{
      .pixels = {kMixedByte, kCarriedByte, kHiddenByte, 0}, .u_end = 3, .v_end = 1};
  MergeMask(other, camera, mask);
  EXPECT_THAT(mask.pixels, testing::ElementsAre(kRobotByte, kCarriedByte, kHiddenByte, 0));
  EXPECT_EQ(mask.u_end, 3);
  RobotMask none;
  MergeMask(other, camera, none);
  EXPECT_EQ(none.pixels, other.pixels);
  MergeMask({}, camera, none);
  EXPECT_EQ(none.pixels, other.pixels);
}

}  // namespace
}  // namespace cwm::perception
