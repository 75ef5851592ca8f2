#include "perception/live/sensor_view.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "perception/live/compare_frame.h"
#include "perception/simulation/look_at.h"
#include "tests/perception/live/still_sensor.h"

namespace cwm::perception {
namespace {

constexpr int kLearning = 30;     // frames: a second
constexpr int kOutliers_px = 10;  // mixed pixels at edges

std::int64_t Count(const FrameEvidence& evidence, PixelClass pixel) {
  return evidence.classes->counts[static_cast<std::size_t>(pixel)];
}

const BodyEvidence& Of(const FrameEvidence& evidence, BodyId id) {
  const auto found = std::ranges::find(evidence.bodies, id, &BodyEvidence::id);
  EXPECT_NE(found, evidence.bodies.end()) << "body " << id;
  static const BodyEvidence none;
  return found == evidence.bodies.end() ? none : *found;
}

// A table with a box, a ball and a can, seen from 1.1 m.
enum TableIds : BodyId { kTable, kBox, kBall, kCan, kNewBox };
SimulatedScene TableScene() {
  SimulatedScene scene;
  const auto add = [&](const char* name, const Shape& shape, const Vector3& place) {
    scene.objects.push_back({.name = name,
                             .parts = {{.shape = shape}},
                             .X_WO = MakePose(place, Quaternion::Identity())});
  };
  add("table",
      Plate{.outline = {{-0.6, -0.6}, {0.6, -0.6}, {0.6, 0.6}, {-0.6, 0.6}},
            .holes = {},
            .thickness_m = 0.03},
      {0, 0, 0});
  scene.objects.back().is_support = true;
  add("box", Box{{0.1, 0.14, 0.08}}, {-0.15, 0.1, 0.04});
  add("ball", Sphere{0.05}, {0.15, 0.1, 0.05});
  add("can", Cylinder{0.04, 0.12}, {0, -0.15, 0.06});
  return scene;
}

StillSensor TableSensor() {
  PinholeCamera camera = Halved({});
  camera.X_WC = LookAt(Vector3(0, 0, 0),
                       ViewingDirection{.distance_m = 1.1, .down_rad = 0.9, .azimuth_rad = 0.4});
  return StillSensor(TableScene(), camera);
}

Vector6 TwistOf(const BodyEvidence& evidence) {
  // Directions that the depths leave open within 5 mm, or 0.1 rad, stay at zero.
  Vector6 prior;
  prior << Vector3::Constant(1 / 25e-6), Vector3::Constant(1 / 0.01);
  const Matrix6 information = evidence.information + Matrix6(prior.asDiagonal());
  return information.ldlt().solve(evidence.moment);
}

TEST(SensorView, FindsNothingWhileNothingChanges) {
  for (const SceneFamily family :
       {SceneFamily::kClutter, SceneFamily::kKitchen, SceneFamily::kVessels}) {
    SimulatedView simulated = RandomScene(family, 31);
    StillSensor sensor(simulated.scene, Halved(simulated.camera));
    const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
    for (int frame = 0; frame < 60; ++frame) {
      const FrameEvidence evidence = sensor.Observe(bodies);
      EXPECT_EQ(evidence.has_reference, frame >= 3);
      EXPECT_EQ(evidence.is_still, frame >= 1);
      ASSERT_EQ(HotBlocks(evidence), 0) << "frame " << frame;
      ASSERT_TRUE(evidence.regions.empty());
      EXPECT_EQ(std::accumulate(evidence.classes->counts.begin(), evidence.classes->counts.end(),
                                std::int64_t{0}),
                320 * 240);
    }
  }
}

TEST(SensorView, LearnsWhatNobodyModelled) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(TableScene());
  SimulatedObject clothes = {.name = "clothes", .parts = {{.shape = Sphere{0.08}}}};
  clothes.X_WO.translation() = Vector3(0.1, 0.9, -0.3);  // beside the table
  sensor.scene.objects.push_back(clothes);
  sensor.Change();
  for (int frame = 0; frame < 20; ++frame) EXPECT_EQ(HotBlocks(sensor.Observe(bodies)), 0);
  sensor.scene.objects.pop_back();
  sensor.scene.objects.push_back(clothes);
  sensor.scene.objects.back().X_WO.translation().x() += 0.05;
  sensor.Change();
  EXPECT_GT(HotBlocks(sensor.Observe(bodies)), 0);
}

TEST(SensorView, TellsAPushedObjectInItsFirstFrame) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  sensor.scene.objects[kCan].X_WO.translation().x() += 0.02;
  sensor.Change();
  const FrameEvidence evidence = sensor.Observe(bodies);
  const BodyEvidence& can = Of(evidence, kCan);
  EXPECT_TRUE(can.is_hot);
  EXPECT_FALSE(Of(evidence, kBall).is_hot);
  EXPECT_FALSE(Of(evidence, kBox).is_hot);
  ASSERT_FALSE(evidence.regions.empty());
  EXPECT_NE(std::ranges::find(evidence.regions.front().bodies, kCan),
            evidence.regions.front().bodies.end());

  // Nearly all points are on the can where it is now, and not on the table.
  ASSERT_GT(can.points_L.size(), 150U);
  EXPECT_LE(can.points_L.size(), static_cast<std::size_t>(kMaxBodyPoints));
  const Pose X_BW = sensor.scene.objects[kCan].X_WO.inverse();
  const double tolerance_m = ExplainedWithin_m(SensorNoise().AxialSigma_m(1.1));
  const auto near = std::ranges::count_if(can.points_L, [&](const Eigen::Vector3f& p_L) {
    const Vector3 p_B = X_BW * (p_L.cast<double>() + sensor.camera.X_WC.translation());
    return std::abs(p_B.head<2>().norm() - 0.04) < tolerance_m ||
           std::abs(p_B.z() - 0.06) < tolerance_m;
  });
  EXPECT_GT(near, 0.9 * static_cast<double>(can.points_L.size()));
}

TEST(SensorView, TellsASmallNewObjectInItsFirstFrame) {
  SimulatedScene scene = TableScene();
  PinholeCamera camera;
  camera.X_WC = LookAt(Vector3(0, 0, 0),
                       ViewingDirection{.distance_m = 1, .down_rad = 1.2, .azimuth_rad = 0.4});
  StillSensor sensor(scene, camera);
  const std::vector<KnownBody> bodies = KnownBodies(scene);
  sensor.Rest(5, bodies);
  sensor.scene.objects.push_back({.name = "cube",
                                  .parts = {{.shape = Box{{0.02, 0.02, 0.02}}}},
                                  .X_WO = MakePose({0.02, 0.03, 0.01}, Quaternion::Identity())});
  sensor.Change();
  const FrameEvidence evidence = sensor.Observe(bodies);
  ASSERT_EQ(evidence.regions.size(), 1U);
  EXPECT_GT(evidence.regions[0].nearer, 50);
  EXPECT_FALSE(evidence.regions[0].points_L.empty());
  EXPECT_EQ(evidence.regions[0].bodies, std::vector<BodyId>{kTable});
}

TEST(SensorView, SeesThroughThePlaceOfWhatWasTaken) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  sensor.scene.objects.erase(sensor.scene.objects.begin() + kBall);
  sensor.Change();
  const BodyEvidence ball = Of(sensor.Observe(bodies), kBall);
  EXPECT_TRUE(ball.is_hot);
  EXPECT_GT(ball.farther, 0.6 * (ball.expected - ball.missing));
  EXPECT_LT(ball.nearer, kOutliers_px);

  // Once the world knows that it is gone, its place is as expected, and is learnt anew.
  std::vector<KnownBody> others = bodies;
  others.erase(others.begin() + kBall);
  EXPECT_EQ(HotBlocks(sensor.Observe(others)), 0);
  sensor.Rest(kLearning, others);
  sensor.scene.objects.push_back({.name = "coin",
                                  .parts = {{.shape = Cylinder{0.03, 0.01}}},
                                  .X_WO = MakePose({0.15, 0.1, 0.005}, Quaternion::Identity())});
  sensor.Change();
  EXPECT_GT(HotBlocks(sensor.Observe(others)), 0);
}

TEST(SensorView, IsNotFooledByWhatPassesInFront) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  SimulatedObject hand = {.name = "hand", .parts = {{.shape = Sphere{0.06}}}};
  const Vector3 camera_W = sensor.camera.X_WC.translation();
  hand.X_WO.translation() = 0.4 * camera_W + 0.6 * Vector3(0.15, 0.1, 0.05);
  sensor.scene.objects.push_back(hand);
  sensor.Change();
  for (int frame = 0; frame < 5; ++frame) {
    const FrameEvidence evidence = sensor.Observe(bodies);
    const BodyEvidence& ball = Of(evidence, kBall);
    EXPECT_GT(ball.nearer, 0.7 * ball.expected);
    EXPECT_LT(ball.farther, kOutliers_px);
    EXPECT_LT(ball.moment_pixels, 20);
    ASSERT_FALSE(evidence.regions.empty());
    EXPECT_GT(evidence.regions[0].points_L.size(), 100U);
    EXPECT_LT(Of(evidence, kBox).nearer, kOutliers_px);
  }
  // It learnt nothing of the hand.
  sensor.scene.objects.pop_back();
  sensor.Change();
  const FrameEvidence after = sensor.Rest(2, bodies);
  EXPECT_EQ(HotBlocks(after), 0);
  EXPECT_GT(Of(after, kBall).consistent, 0.7 * Of(after, kBall).expected);
}

TEST(SensorView, TakesMissingPixelsForNoEvidence) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  auto image = sensor.Measure();
  std::ranges::fill(image->depth_m, 0.F);
  for (int frame = 0; frame < 3; ++frame) {
    const FrameEvidence evidence = sensor.Observe(image, bodies);
    EXPECT_EQ(HotBlocks(evidence), 0);
    EXPECT_EQ(Count(evidence, PixelClass::kMissing), 320 * 240);
    for (const BodyEvidence& body : evidence.bodies) {
      EXPECT_EQ(body.missing, body.expected);
      EXPECT_EQ(body.moment_pixels, 0);
      EXPECT_TRUE(body.information.isZero());
    }
  }
  EXPECT_EQ(HotBlocks(sensor.Observe(bodies)), 0);
}

TEST(SensorView, LeavesThePixelsOfRobotsAlone) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  // An arm over the upper half of the image, with a fringe of each class.
  RobotMask robots;
  robots.pixels.resize(std::size_t{320} * 240, 0);
  robots.u_end = 320;
  robots.v_end = 120;
  for (int v = 0; v < 120; ++v) {
    const PixelClass pixel = v < 100   ? PixelClass::kRobot
                             : v < 110 ? PixelClass::kCarried
                             : v < 115 ? PixelClass::kMixed
                                       : PixelClass::kHidden;
    std::fill_n(robots.pixels.begin() + std::ptrdiff_t{320} * v, 320,
                static_cast<std::uint8_t>(pixel));
  }
  for (int frame = 0; frame < 40; ++frame) {
    auto image = sensor.Measure();
    std::fill_n(image->depth_m.begin(), 320 * 120, 0.5F);
    const FrameEvidence evidence = sensor.Observe(image, bodies, robots);
    ASSERT_EQ(HotBlocks(evidence), 0);
    EXPECT_EQ(Count(evidence, PixelClass::kRobot), 320 * 100);
    EXPECT_EQ(Count(evidence, PixelClass::kCarried), 320 * 10);
    EXPECT_EQ(Count(evidence, PixelClass::kMixed), 320 * 5);
    EXPECT_EQ(Count(evidence, PixelClass::kHidden), 320 * 5);
    EXPECT_GT(Of(evidence, kTable).hidden, 10000);
    EXPECT_LT(Of(evidence, kTable).nearer, kOutliers_px);
  }
  EXPECT_EQ(HotBlocks(sensor.Observe(bodies)), 0);
}

TEST(SensorView, MeasuresASmallMotionOfABody) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  // measured: means over a hand's breadth move by 0.4 mm from frame to frame.
  constexpr double kTolerance_m = 0.0015;
  const Vector6 at_rest = TwistOf(Of(sensor.Observe(bodies), kBox));
  EXPECT_LT(at_rest.head<3>().norm(), kTolerance_m);
  const Vector3 motion(0.002, -0.003, 0.001);
  sensor.scene.objects[kBox].X_WO.translation() += motion;
  sensor.Change();
  const FrameEvidence evidence = sensor.Observe(bodies);
  const Vector6 twist = TwistOf(Of(evidence, kBox));
  EXPECT_GT(Of(evidence, kBox).moment_pixels, 100);
  EXPECT_LT((twist.head<3>() - motion).norm(), kTolerance_m) << twist.transpose();
  EXPECT_LT(twist.tail<3>().norm(), 0.02);
  EXPECT_LT(TwistOf(Of(evidence, kTable)).head<3>().norm(), kTolerance_m);

  // The reference goes with the body to the pose that the world gives it.
  std::vector<KnownBody> moved = bodies;
  moved[kBox].X_WB = sensor.scene.objects[kBox].X_WO;
  const FrameEvidence after = sensor.Observe(moved);
  EXPECT_LT(TwistOf(Of(after, kBox)).head<3>().norm(), kTolerance_m);
  EXPECT_EQ(HotBlocks(after), 0);
}

TEST(SensorView, FollowsASlowDriftOfTheSensor) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  // 8 mm within 20 seconds: more than what tells a change at once.
  constexpr int kFrames = 600;
  for (int frame = 0; frame < kFrames; ++frame) {
    auto image = sensor.Measure();
    for (float& depth_m : image->depth_m) {
      if (depth_m > 0) depth_m += 0.008F * static_cast<float>(frame) / kFrames;
    }
    ASSERT_EQ(HotBlocks(sensor.Observe(image, bodies)), 0) << "frame " << frame;
  }
}

TEST(SensorView, AcceptsWhatNobodyCanModel) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  sensor.scene.objects.push_back({.name = "new",
                                  .parts = {{.shape = Box{{0.1, 0.1, 0.05}}}},
                                  .X_WO = MakePose({0.1, -0.1, 0.025}, Quaternion::Identity())});
  sensor.Change();
  FrameEvidence evidence = sensor.Rest(15, bodies);
  ASSERT_EQ(evidence.regions.size(), 1U);
  EXPECT_GE(evidence.regions[0].rest_frames, 12);
  EXPECT_NEAR(evidence.regions[0].rest_s, 0.033 * evidence.regions[0].rest_frames, 1e-6);
  sensor.view.Accept(evidence.regions[0].blocks);
  for (int frame = 0; frame < kLearning; ++frame) EXPECT_EQ(HotBlocks(sensor.Observe(bodies)), 0);
  sensor.scene.objects.back().X_WO.translation().x() += 0.03;
  sensor.Change();
  EXPECT_GT(HotBlocks(sensor.Observe(bodies)), 0);
}

TEST(SensorView, TellsWhatMovesFromWhatRests) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.Rest(kLearning, bodies);
  sensor.scene.objects.push_back({.name = "new",
                                  .parts = {{.shape = Sphere{0.06}}},
                                  .X_WO = MakePose({0.1, -0.1, 0.2}, Quaternion::Identity())});
  for (int frame = 0; frame < 10; ++frame) {
    sensor.scene.objects.back().X_WO.translation().z() += 0.01;
    sensor.Change();
    const FrameEvidence evidence = sensor.Observe(bodies);
    ASSERT_FALSE(evidence.regions.empty());
    EXPECT_LE(evidence.regions[0].rest_frames, 1);
  }
}

TEST(SensorView, KeepsAContradictionToTheWorldHot) {
  // A body that is not there from the first frame on, and one that nobody told.
  StillSensor sensor = TableSensor();
  std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  sensor.scene.objects.erase(sensor.scene.objects.begin() + kBox);
  sensor.Change();
  std::erase_if(bodies, [](const KnownBody& body) { return body.id == kCan; });
  const FrameEvidence evidence = sensor.Rest(kLearning, bodies);
  EXPECT_TRUE(evidence.has_reference);
  EXPECT_GT(Of(evidence, kBox).farther, 0.5 * Of(evidence, kBox).expected);
  EXPECT_EQ(evidence.regions.size(), 2U);
  EXPECT_GT(Count(evidence, PixelClass::kNearer), 300);
}

TEST(SensorView, SeesThroughABodyThatLeftWhileItWasModelled) {
  // The body is expected in the frame before that is noted, or in the one after.
  for (const bool is_expected_first : {false, true}) {
    SCOPED_TRACE(is_expected_first);
    StillSensor sensor = TableSensor();
    const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
    sensor.Rest(kLearning, bodies);
    sensor.scene.objects.push_back({.name = "hand",
                                    .parts = {{.shape = Box{{0.08, 0.08, 0.1}}}},
                                    .X_WO = MakeTranslation(0, 0.1, 0.05)});
    sensor.Change();
    const std::vector<KnownBody> with_hand = KnownBodies(sensor.scene);
    const FrameEvidence interpreted = sensor.Rest(10, bodies);
    ASSERT_EQ(interpreted.regions.size(), 1U);
    sensor.scene.objects.pop_back();
    sensor.Change();
    sensor.Rest(5, bodies);
    if (is_expected_first) sensor.Observe(with_hand);
    sensor.view.NoteInterpreted(interpreted, interpreted.regions[0].blocks);
    const BodyEvidence hand = Of(sensor.Observe(with_hand), kNewBox);
    EXPECT_GT(hand.passed, 0.5 * hand.expected);
    EXPECT_LT(hand.shown, 0.1 * hand.expected);
    EXPECT_EQ(Of(sensor.Observe(bodies), kBall).is_hot, false);
    EXPECT_EQ(HotBlocks(sensor.Rest(5, bodies)), 0);
  }
}

TEST(SensorView, ComparesAMovingSensorWithTheExpectedViewAlone) {
  StillSensor sensor = TableSensor();
  std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  const Pose X_WC = sensor.camera.X_WC;
  for (int frame = 0; frame < 20; ++frame) {
    sensor.camera.X_WC = X_WC;
    sensor.camera.X_WC.translation().x() += 0.01 * (frame + 1);
    sensor.Change();
    if (frame == 15) {
      std::erase_if(bodies, [](const KnownBody& body) { return body.id == kCan; });
      bodies.push_back({.id = kNewBox,
                        .X_WB = MakePose({-0.25, -0.25, 0.04}, Quaternion::Identity()),
                        .model = bodies[kBox].model});
    }
    const FrameEvidence evidence = sensor.Observe(bodies);
    EXPECT_FALSE(evidence.is_still);
    EXPECT_FALSE(evidence.has_reference);
    for (const BodyEvidence& body : evidence.bodies) EXPECT_EQ(body.moment_pixels, 0);
    if (frame < 15) {
      EXPECT_EQ(HotBlocks(evidence), 0) << "frame " << frame;
    } else {
      EXPECT_GT(Of(evidence, kNewBox).farther, 0.5 * Of(evidence, kNewBox).expected);
      EXPECT_GT(Count(evidence, PixelClass::kNearer), 300);
      EXPECT_GE(evidence.regions.size(), 2U);
    }
  }
}

TEST(SensorView, TakesImagesOfAnySize) {
  for (const auto& [width, height] : {std::pair(1, 1), {7, 5}, {9, 17}, {321, 100}}) {
    PinholeCamera camera = Halved({});
    camera.width = width;
    camera.height = height;
    camera.X_WC = LookAt(Vector3(-0.15, 0.1, 0.05),
                         ViewingDirection{.distance_m = 1, .down_rad = 1, .azimuth_rad = 0});
    camera.center_x_px = 0.5 * (width - 1);
    camera.center_y_px = 0.5 * (height - 1);
    StillSensor sensor(TableScene(), camera);
    const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
    FrameEvidence evidence = sensor.Rest(40, bodies);
    EXPECT_EQ(HotBlocks(evidence), 0);
    EXPECT_EQ(evidence.classes->pixels.size(), static_cast<std::size_t>(width) * height);
    EXPECT_EQ(evidence.classes->block_columns, (width + 7) / 8);
    EXPECT_EQ(evidence.classes->block_rows, (height + 7) / 8);
    sensor.scene.objects.clear();
    sensor.Change();
    evidence = sensor.Rest(3, bodies);
    EXPECT_EQ(Count(evidence, PixelClass::kMissing), width * height);
    sensor.view.Accept(std::vector<std::int32_t>{0, 1, 1000000, -1});
    sensor.Observe(bodies);
  }
}

TEST(SensorView, ToleratesDepthsThatAreNoNumbers) {
  StillSensor sensor = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(sensor.scene);
  for (int frame = 0; frame < 40; ++frame) {
    auto image = sensor.Measure();
    for (std::size_t i = static_cast<std::size_t>(frame % 3); i < image->depth_m.size(); i += 5) {
      image->depth_m[i] = frame % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : 1e9F;
    }
    const FrameEvidence evidence = sensor.Observe(image, bodies);
    EXPECT_EQ(HotBlocks(evidence), 0);
    EXPECT_GE(Count(evidence, PixelClass::kMissing), 320 * 240 / 5);
    for (const BodyEvidence& body : evidence.bodies) {
      EXPECT_TRUE(body.information.allFinite());
      EXPECT_TRUE(body.moment.allFinite());
    }
  }
}

TEST(SensorView, GivesTheSameEvidenceForTheSameFrames) {
  StillSensor first = TableSensor();
  StillSensor second = TableSensor();
  const std::vector<KnownBody> bodies = KnownBodies(first.scene);
  for (int frame = 0; frame < 10; ++frame) {
    if (frame == 6) {
      first.scene.objects[kCan].X_WO.translation().x() += 0.03;
      second.scene.objects[kCan].X_WO.translation().x() += 0.03;
      first.Change();
      second.Change();
    }
    const FrameEvidence a = first.Observe(bodies);
    second.view.Expect(bodies, second.camera.X_WC);  // as the robot's mask needs it
    const FrameEvidence b = second.Observe(bodies);
    EXPECT_EQ(a.classes->pixels, b.classes->pixels);
    ASSERT_EQ(a.bodies.size(), b.bodies.size());
    for (std::size_t i = 0; i < a.bodies.size(); ++i) {
      EXPECT_EQ(a.bodies[i].moment, b.bodies[i].moment);
      EXPECT_EQ(a.bodies[i].points_L, b.bodies[i].points_L);
    }
  }
}

TEST(BodyPixelsTest, CountsTheBodiesOfOneFrameAlone) {
  constexpr auto kNearer = static_cast<std::size_t>(PixelClass::kNearer);
  BodyPixels pixels;
  const BodyPixels& read = pixels;
  pixels.of(kNoBody)[kNearer] += 5;
  pixels.of(7)[kNearer] += 2;
  pixels.of(kNoBody)[kNearer] += 1;
  EXPECT_EQ(read.of(kNoBody)[kNearer], 6);
  EXPECT_EQ(read.of(7)[kNearer], 2);
  EXPECT_EQ(read.of(0), PixelCounts());
  pixels.Clear();
  EXPECT_EQ(read.of(kNoBody), PixelCounts());
  EXPECT_EQ(read.of(7), PixelCounts());
  pixels.of(8)[kNearer] += 3;
  EXPECT_EQ(read.of(8)[kNearer], 3);
  EXPECT_EQ(read.of(7), PixelCounts());
}

}  // namespace
}  // namespace cwm::perception
