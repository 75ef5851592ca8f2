#include "perception/segmentation/up_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "perception/cloud/tolerances.h"
#include "perception/segmentation/segment_scene.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kWithin_rad = 1 * kDegree;

SimulatedObject Block(const char* name, const Vector3& min_W, const Vector3& max_W) {
  return {.name = name,
          .parts = {{.shape = Box{max_W - min_W}}},
          .X_WO = Pose(Eigen::Translation3d(0.5 * (min_W + max_W)))};
}

// A table with two boxes and a can on it before a wall that covers more of the view.
SimulatedScene TableBeforeAWall() {
  return {{Block("table", {-0.4, -0.6, -0.03}, {0.4, 0.6, 0}),
           Block("wall", {0.6, -3, -1}, {0.7, 3, 2}),
           Block("box", {0, 0.1, 0}, {0.1, 0.25, 0.12}),
           Block("low box", {-0.1, -0.3, 0}, {0.06, -0.1, 0.06}),
           {.name = "can",
            .parts = {{.shape = Cylinder{0.04, 0.11}}},
            .X_WO = MakeTranslation(-0.2, 0, 0.055)}}};
}

PinholeCamera CameraAt(double down_rad, double roll_rad) {
  PinholeCamera camera;
  camera.X_WC =
      LookAt(Vector3(0, 0, 0.1), ViewingDirection{.distance_m = 1.3, .down_rad = down_rad});
  camera.X_WC.rotate(Eigen::AngleAxisd(roll_rad, Vector3::UnitZ()));
  return camera;
}

// The scan as a list of points in axes that follow from the optical ones by a rotation.
PointCloud ListOf(const SimulatedScene& scene, const PinholeCamera& camera,
                  const Matrix3& R_from_optical) {
  PointCloud cloud = Scan(scene, camera, {}).cloud;
  std::erase_if(cloud.points, [](const Eigen::Vector3f& p) { return !p.allFinite(); });
  std::shuffle(cloud.points.begin(), cloud.points.end(), std::mt19937(1));
  for (Eigen::Vector3f& p : cloud.points) p = R_from_optical.cast<float>() * p;
  cloud.normals.clear();
  cloud.width = static_cast<int>(cloud.size());
  cloud.height = 1;
  return cloud;
}

struct FoundUp {
  UpSource source = UpSource::kNoPlane;
  double error_rad = 0;
};

FoundUp FindUp(const PointCloud& cloud, const Vector3& true_up_C) {
  auto scene = SegmentScene(*CollectMeasured(cloud, {}), {});
  EXPECT_TRUE(scene.ok()) << scene.status();
  return {scene->up_source,
          std::acos(std::clamp(Vector3(scene->R_LC.row(2)).dot(true_up_C), -1.0, 1.0))};
}

Matrix3 Optical() { return Matrix3::Identity(); }
Matrix3 Viewer() { return Vector3(1, -1, -1).asDiagonal(); }
Matrix3 Body() {
  Matrix3 R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return R;
}

TEST(UpOfAList, IsThatOfTheTableAndNotOfTheWallBehindIt) {
  for (const double roll_deg : {0.0, 90.0, 180.0}) {
    const PinholeCamera camera = CameraAt(20 * kDegree, roll_deg * kDegree);
    const Vector3 up_C = camera.X_WC.linear().row(2);
    for (const Matrix3& R : {Optical(), Viewer(), Body()}) {
      const FoundUp found = FindUp(ListOf(TableBeforeAWall(), camera, R), R * up_C);
      EXPECT_LT(found.error_rad, kWithin_rad) << "rolled by " << roll_deg << "\n" << R;
      EXPECT_EQ(found.source, UpSource::kSupport);
    }
  }
}

// Without things, the floor and the wall of a corner look alike; the sensor's axes decide.
TEST(UpOfAList, FollowsTheConventionWhereNothingStands) {
  const SimulatedScene corner{
      {Block("floor", {-2, -3, -0.1}, {0.6, 3, 0}), Block("wall", {0.6, -3, -1}, {0.7, 3, 2})}};
  const PinholeCamera camera = CameraAt(15 * kDegree, 0);
  const Vector3 up_C = camera.X_WC.linear().row(2);
  for (const Matrix3& R : {Optical(), Viewer(), Body()}) {
    EXPECT_LT(FindUp(ListOf(corner, camera, R), R * up_C).error_rad, kWithin_rad) << R;
  }
}

TEST(UpOfAnImage, IsTowardsACameraOverABin) {
  SimulatedScene bin{{Block("floor", {-1, -1, -0.03}, {1, 1, 0})}};
  for (const double side : {-1.0, 1.0}) {
    bin.objects.push_back(
        Block("end", {0.3 * side - 0.005, -0.2, 0}, {0.3 * side + 0.005, 0.2, 0.15}));
    bin.objects.push_back(
        Block("side", {-0.3, 0.2 * side - 0.005, 0}, {0.3, 0.2 * side + 0.005, 0.15}));
    bin.objects.push_back(
        Block("box", {0.15 * side - 0.05, -0.06, 0}, {0.15 * side + 0.05, 0.07, 0.1}));
  }
  for (const double down_deg : {80.0, 90.0}) {
    const PinholeCamera camera = CameraAt(down_deg * kDegree, 30 * kDegree);
    const FoundUp found = FindUp(Scan(bin, camera, {}).cloud, camera.X_WC.linear().row(2));
    EXPECT_LT(found.error_rad, kWithin_rad) << down_deg;
    EXPECT_EQ(found.source, UpSource::kSupport);
  }
}

TEST(UpEvidence, GrowsWithWhatSpeaksForIt) {
  const UpEvidence bare{.facing_share = 0.4, .image_cos = 0.5};
  UpEvidence more = bare;
  more.facing_share = 0.5;
  EXPECT_GT(more.LogOdds(), bare.LogOdds());
  more = bare;
  more.thing_cells = 20;
  EXPECT_GT(more.LogOdds(), bare.LogOdds());
  more = bare;
  more.image_cos = 0.9;
  EXPECT_GT(more.LogOdds(), bare.LogOdds());
  UpEvidence ceiling{.hanging_share = 0.4, .image_cos = 0.5};
  EXPECT_LT(ceiling.LogOdds(), bare.LogOdds());
}

TEST(AxesOfList, AreTheConventionThatThePointsShow) {
  const auto axes_of = [](const Eigen::Vector3f& middle) {
    OrientedPoints points;
    for (const float x : {-0.2f, 0.2f}) {
      for (const float y : {-0.2f, 0.2f}) {
        points.points.push_back(middle + Eigen::Vector3f(x, y, 0.1f * x));
      }
    }
    return AxesOfList(points);
  };
  EXPECT_EQ(axes_of({0, 0, 1}).up, Vector3(0, -1, 0));
  EXPECT_EQ(axes_of({0, 0, -1}).up, Vector3(0, 1, 0));
  EXPECT_EQ(axes_of({1, 0, 0}).up, Vector3(0, 0, 1));
  EXPECT_EQ(axes_of({0, 1, 0}).up, Vector3::Zero());
  const ImageAxes all_around = axes_of(Eigen::Vector3f::Zero());
  EXPECT_EQ(all_around.up, Vector3(0, 0, 1));
  EXPECT_TRUE(all_around.is_all_around);
}

}  // namespace
}  // namespace cwm::perception
