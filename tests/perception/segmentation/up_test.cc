// The up direction, checked on scenes of the virtual scanner: right, upside down, given or
// estimated.
#include "perception/segmentation/up.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/segment_scene.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

// The scanner's warp of 1.3 mm over 0.2 m tilts a scene by less than half a degree, a patch of 0.4
// m by less than one degree.
constexpr double kUpError_rad = 1 * kDegree;

SimulatedObject Block(const Vector3& size_m, const Vector3& middle_m) {
  return {.name = "block",
          .parts = {{.shape = Box{size_m}}},
          .X_WO = MakeTranslation(middle_m.x(), middle_m.y(), middle_m.z())};
}

// A table whose top is at z = 0.
SimulatedObject TableTop() { return Block({1.2, 1.6, 0.03}, {0, 0, -0.015}); }

SimulatedScene TableWithObjects() {
  return {{TableTop(), Block({0.12, 0.3, 0.3}, {-0.28, 0, 0.15}),
           Block({0.1, 0.1, 0.12}, {0.15, 0.15, 0.06})}};
}

// A ceiling 1.5 m above a camera that looks at it from below.
SimulatedScene Ceiling() { return {{Block({6, 6, 0.2}, {0, 0, 1.6})}}; }

PinholeCamera CameraAt(const Pose& X_WC) {
  PinholeCamera camera;
  camera.X_WC = X_WC;
  return camera;
}

PinholeCamera LookingDown(double down_rad) {
  return CameraAt(
      LookAt(Vector3::Zero(), ViewingDirection{.distance_m = 1.1, .down_rad = down_rad}));
}

PinholeCamera LookingUp() { return CameraAt(LookAt(Vector3::Zero(), Vector3(1, 0, 1))); }

// The camera turned about its optical axis.
PinholeCamera Rolled(PinholeCamera camera, double roll_rad) {
  camera.X_WC.linear() *= Eigen::AngleAxisd(roll_rad, Vector3::UnitZ()).toRotationMatrix();
  return camera;
}

Vector3 TrueUp(const PinholeCamera& camera) { return camera.X_WC.linear().row(2).transpose(); }

PointCloud Shuffled(PointCloud cloud) {
  std::shuffle(cloud.points.begin(), cloud.points.end(), std::mt19937(1));
  cloud.width = static_cast<int>(cloud.size());
  cloud.height = 1;
  return cloud;
}

SegmentedScene Segmented(const PointCloud& cloud, const SegmentOptions& options) {
  auto scene = SegmentScene(*CollectMeasured(cloud, {}), options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

SegmentedScene WithUp(const SimulatedScene& scene, const PinholeCamera& camera,
                      const Vector3& up_C) {
  SegmentOptions options;
  options.up_C = up_C;
  return Segmented(Scan(scene, camera, {}).cloud, options);
}

double UpError_rad(const SegmentedScene& scene, const PinholeCamera& camera) {
  return std::acos(std::min(1.0, scene.R_LC.row(2).dot(TrueUp(camera))));
}

TEST(GivenUp, ThatIsRightIsTaken) {
  for (const double down : {35 * kDegree, 90 * kDegree}) {
    const PinholeCamera camera = LookingDown(down);
    const SegmentedScene scene = WithUp(TableWithObjects(), camera, TrueUp(camera));
    EXPECT_EQ(scene.up_verdict, UpVerdict::kPlausible);
    EXPECT_LT(UpError_rad(scene, camera), 1e-6);
    EXPECT_FALSE(scene.supports.empty());
  }
}

TEST(GivenUp, ThatIsUpsideDownIsTakenTheOtherWayRound) {
  for (const double down : {35 * kDegree, 60 * kDegree}) {
    const PinholeCamera camera = LookingDown(down);
    const SegmentedScene reversed = WithUp(TableWithObjects(), camera, -2 * TrueUp(camera));
    EXPECT_EQ(reversed.up_verdict, UpVerdict::kReversed);
    EXPECT_LT(UpError_rad(reversed, camera), 1e-6);
    const SegmentedScene right = WithUp(TableWithObjects(), camera, TrueUp(camera));
    EXPECT_EQ(reversed.hypotheses.size(), right.hypotheses.size());
  }
}

// Seen from straight above or by a camera on its side, the image does not show which side is up;
// objects that stand on the table do.
TEST(GivenUp, ThatIsUpsideDownIsToldByWhatStandsWhereTheImageIsSilent) {
  for (const PinholeCamera& camera :
       {LookingDown(90 * kDegree), Rolled(LookingDown(45 * kDegree), 90 * kDegree)}) {
    EXPECT_EQ(WithUp(TableWithObjects(), camera, -TrueUp(camera)).up_verdict, UpVerdict::kReversed);
    EXPECT_EQ(WithUp({{TableTop()}}, camera, -TrueUp(camera)).up_verdict, UpVerdict::kSeenFromBelow)
        << "of a bare board nobody knows";
  }
}

TEST(GivenUp, IsKeptUnderACeiling) {
  const PinholeCamera camera = LookingUp();
  const SegmentedScene scene = WithUp(Ceiling(), camera, TrueUp(camera));
  EXPECT_EQ(scene.up_verdict, UpVerdict::kSeenFromBelow);
  EXPECT_LT(UpError_rad(scene, camera), 1e-6);
}

// A room: another level surface, seen from above, shows that the sensor stands upright.
TEST(GivenUp, IsNotDoubtedWhereAFloorIsSeenToo) {
  PinholeCamera camera = CameraAt(LookAt(Vector3::Zero(), Vector3(1, 0, 0)));
  camera.focal_px = 250;  // as wide as it is high: both are seen
  SimulatedScene room = Ceiling();
  room.objects.push_back(Block({6, 6, 0.2}, {0, 0, -1.6}));
  EXPECT_EQ(WithUp(room, camera, TrueUp(camera)).up_verdict, UpVerdict::kPlausible);
}

TEST(GivenUp, OfAGivenOrientationIsDoubtedButNotTurned) {
  const PinholeCamera camera = LookingDown(35 * kDegree);
  SegmentOptions options;
  options.R_LC = Matrix3(Vector3(1, -1, -1).asDiagonal()) * camera.X_WC.linear();
  const SegmentedScene scene = Segmented(Scan(TableWithObjects(), camera, {}).cloud, options);
  EXPECT_EQ(scene.up_verdict, UpVerdict::kReversed);
  EXPECT_EQ(scene.R_LC, *options.R_LC);
}

// The cloud may be merged from several viewpoints: its frame is not turned.
TEST(GivenUp, OfACloudThatIsNoImageIsDoubtedByWhatStandsAlone) {
  const PinholeCamera camera = LookingDown(35 * kDegree);
  SegmentOptions options;
  options.up_C = -TrueUp(camera);
  const PointCloud cloud = Shuffled(Scan(TableWithObjects(), camera, {}).cloud);
  const SegmentedScene scene = Segmented(cloud, options);
  EXPECT_EQ(scene.up_verdict, UpVerdict::kSeenFromBelow);
  EXPECT_LT(scene.R_LC.row(2).dot(TrueUp(camera)), -0.99);
  options.up_C = TrueUp(camera);
  EXPECT_EQ(Segmented(cloud, options).up_verdict, UpVerdict::kPlausible);
}

TEST(EstimatedUp, IsKnownFromATableAndFromObjectsThatStand) {
  EXPECT_EQ(Segmented(Scan({{TableTop()}}, LookingDown(35 * kDegree), {}).cloud, {}).up_source,
            UpSource::kSupport);
  const PointCloud cloud = Scan(TableWithObjects(), LookingDown(35 * kDegree), {}).cloud;
  EXPECT_EQ(Segmented(Shuffled(cloud), {}).up_source, UpSource::kSupport);
}

// A box's side points upwards in the image as the normals of supports do, but it is small.
TEST(EstimatedUp, OfATableSeenFromStraightAboveOrByACameraOnItsSide) {
  for (const PinholeCamera& camera :
       {LookingDown(90 * kDegree), Rolled(LookingDown(90 * kDegree), 90 * kDegree),
        Rolled(LookingDown(90 * kDegree), 180 * kDegree),
        Rolled(LookingDown(45 * kDegree), 90 * kDegree),
        Rolled(LookingDown(45 * kDegree), -90 * kDegree)}) {
    const SegmentedScene scene = Segmented(Scan(TableWithObjects(), camera, {}).cloud, {});
    EXPECT_LT(UpError_rad(scene, camera), kUpError_rad);
    EXPECT_EQ(scene.up_source, UpSource::kSupport) << "objects stand on it";
  }
}

TEST(EstimatedUp, OfACloudThatIsNoImage) {
  for (const PinholeCamera& camera : {LookingDown(35 * kDegree), LookingDown(90 * kDegree),
                                      Rolled(LookingDown(45 * kDegree), 130 * kDegree)}) {
    const SegmentedScene scene =
        Segmented(Shuffled(Scan(TableWithObjects(), camera, {}).cloud), {});
    EXPECT_LT(UpError_rad(scene, camera), kUpError_rad);
    EXPECT_EQ(scene.up_source, UpSource::kSupport);
    EXPECT_FALSE(scene.supports.empty());
  }
}

TEST(EstimatedUp, OfAnImageInABodysFrame) {
  const PinholeCamera camera = LookingDown(35 * kDegree);
  PointCloud body = Scan(TableWithObjects(), camera, {}).cloud;
  Matrix3 to_body;
  to_body << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  for (Eigen::Vector3f& p : body.points) p = to_body.cast<float>() * p;
  const SegmentedScene scene = Segmented(body, {});
  EXPECT_GT(scene.R_LC.row(2).dot(to_body * TrueUp(camera)), std::cos(kUpError_rad));
  EXPECT_GT(scene.R_LC(0, 0), 0.5) << "the world's x is along the view";
}

// Walls are larger than the objects in front of them, but not larger than the support of those
// objects.
TEST(EstimatedUp, OfACounterBeforeAWall) {
  SimulatedScene counter = TableWithObjects();
  counter.objects.push_back(Block({0.1, 3, 3}, {0.65, 0, 0}));
  for (const double down : {12 * kDegree, 25 * kDegree}) {
    const PinholeCamera camera = CameraAt(
        LookAt(Vector3(0.2, 0, 0.1), ViewingDirection{.distance_m = 1.2, .down_rad = down}));
    const SegmentedScene scene = Segmented(Scan(counter, camera, {}).cloud, {});
    EXPECT_LT(UpError_rad(scene, camera), kUpError_rad);
  }
}

TEST(EstimatedUp, OfABareWallOrALineIsAGuess) {
  const PinholeCamera camera = CameraAt(LookAt(Vector3::Zero(), Vector3(1, 0, 0)));
  const SimulatedScene wall{{Block({0.2, 6, 6}, {1.5, 0, 0})}};
  EXPECT_EQ(Segmented(Scan(wall, camera, {}).cloud, {}).up_source, UpSource::kBarePlane);
  PointCloud line;
  for (int i = 0; i < 2000; ++i) line.points.push_back({0.001f * static_cast<float>(i), 0, 1});
  line.width = static_cast<int>(line.size());
  EXPECT_EQ(Segmented(line, {}).up_source, UpSource::kNoPlane);
  EXPECT_EQ(Segmented({.points = {{0, 0, 1}}, .normals = {}, .width = 1}, {}).up_source,
            UpSource::kNoPlane);
}

TEST(ImageAxes, AreTheOnesThatTheRaysTell) {
  const PointCloud optical = Scan(TableWithObjects(), LookingDown(35 * kDegree), {}).cloud;
  const ImageAxes of_camera = AxesOf(*CollectMeasured(optical, {}));
  EXPECT_EQ(of_camera.forward, Vector3::UnitZ());
  EXPECT_EQ(of_camera.up, Vector3(-Vector3::UnitY()));
  PointCloud body = optical;  // x forward, y left, z up
  for (Eigen::Vector3f& p : body.points) p = Eigen::Vector3f(p.z(), -p.x(), -p.y());
  const ImageAxes of_body = AxesOf(*CollectMeasured(body, {}));
  EXPECT_EQ(of_body.forward, Vector3::UnitX());
  EXPECT_EQ(of_body.up, Vector3::UnitZ());
}

TEST(MeasuredPoints, HaveTheNoiseOfTheirDepthWhateverAxisOfTheirFrameThatIs) {
  const PointCloud optical = Scan(TableWithObjects(), LookingDown(35 * kDegree), {}).cloud;
  PointCloud body = optical;
  for (Eigen::Vector3f& p : body.points) p = Eigen::Vector3f(p.z(), -p.x(), -p.y());
  EXPECT_EQ(CollectMeasured(body, {})->oriented.sigma_m,
            CollectMeasured(optical, {})->oriented.sigma_m);
}

}  // namespace
}  // namespace cwm::perception
