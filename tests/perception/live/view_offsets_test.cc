// The offsets of three views of one body, whose points lie exactly on it but for these.
#include "perception/live/view_offsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/geometry/signed_distance.h"

namespace cwm::perception {
namespace {

constexpr int kPointsPerView = 1500;
const Vector3 kSensors[] = {{-0.6, 0, 0.8}, {0.1, -0.7, 0.75}, {0.1, 0.7, 0.75}};
const double kOffsets_m[] = {0.0012, -0.0018, 0.0006};
// A tenth of the largest one.
constexpr double kTolerance_m = 0.00018;

// The points of the shape's upper surface that face each sensor, each view too far by its offset.
std::vector<BodyView> ViewsOf(const Shape& shape, const Pose& X_FS, double reach_m,
                              const double (&offsets_m)[3]) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> across(-reach_m, reach_m);
  std::vector<BodyView> views;
  for (int v = 0; v < 3; ++v) {
    BodyView& view = views.emplace_back();
    view.sensor = kSensors[v];
    while (view.points.size() < kPointsPerView) {
      const Vector3 p_S(across(random), across(random), across(random));
      const SurfacePoint surface = NearestSurfacePoint(shape, p_S);
      const Vector3 p = X_FS * surface.nearest;
      const Vector3 ray = (p - view.sensor).normalized();
      const bool is_seen = (X_FS.linear() * surface.normal).dot(ray) < -0.3;
      if (is_seen) view.points.push_back((p + offsets_m[v] * ray).cast<float>());
    }
  }
  return views;
}

void ExpectOffsets(const Shape& shape, const Shape& start, double reach_m) {
  const Pose X_FS =
      MakePose(Vector3(0.02, -0.01, 0.05), Quaternion(Eigen::AngleAxisd(0.4, Vector3::UnitZ())));
  const std::vector<BodyView> views = ViewsOf(shape, X_FS, reach_m, kOffsets_m);
  const Pose X_FS_start = MakeTranslation(0.0015, -0.001, 0.001) * X_FS;
  const std::vector<double> offsets_m = ViewOffsets_m(views, start, X_FS_start, {});
  ASSERT_EQ(offsets_m.size(), 3U);
  for (int v = 0; v < 3; ++v) EXPECT_NEAR(offsets_m[v], kOffsets_m[v], kTolerance_m) << v;
}

TEST(ViewOffsetsTest, OffsetsOfViewsOfABallAreFoundWithItsRadius) {
  ExpectOffsets(Sphere{.radius_m = 0.045}, Sphere{.radius_m = 0.047}, 0.06);
}

TEST(ViewOffsetsTest, OffsetsOfViewsOfACanAreFoundWithItsRadiusAndLength) {
  ExpectOffsets(Cylinder{.radius_m = 0.04, .length_m = 0.1},
                Cylinder{.radius_m = 0.042, .length_m = 0.099}, 0.07);
}

TEST(ViewOffsetsTest, OffsetsOfViewsOfACupAreFoundWithItsRadiiAndLength) {
  ExpectOffsets(Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.045, .length_m = 0.09},
                Cone{.radius_bottom_m = 0.032, .radius_top_m = 0.044, .length_m = 0.091}, 0.07);
}

// Flat faces have no curvature: where the views of a box overlap they tell how their offsets differ,
// to a tenth of the largest difference.
TEST(ViewOffsetsTest, OffsetsOfViewsOfABoxDifferAsTheyShould) {
  const Shape box = Box{.size_m = {0.08, 0.06, 0.1}};
  const std::vector<BodyView> views = ViewsOf(box, Pose::Identity(), 0.07, kOffsets_m);
  const std::vector<double> offsets_m = ViewOffsets_m(views, Box{.size_m = {0.081, 0.0595, 0.101}},
                                                      MakeTranslation(0.001, 0, 0.0005), {});
  ASSERT_EQ(offsets_m.size(), 3U);
  for (const int v : {1, 2}) {
    EXPECT_NEAR(offsets_m[v] - offsets_m[0], kOffsets_m[v] - kOffsets_m[0], 0.0003) << v;
  }
}

TEST(ViewOffsetsTest, WhatIsNotOfTheBodyDoesNotMoveTheOffsets) {
  const Shape can = Cylinder{.radius_m = 0.04, .length_m = 0.1};
  std::vector<BodyView> views = ViewsOf(can, Pose::Identity(), 0.07, kOffsets_m);
  const std::vector<double> alone_m = ViewOffsets_m(views, can, Pose::Identity(), {});
  std::mt19937 random(3);
  std::uniform_real_distribution<float> along(-0.03F, 0.03F);
  for (BodyView& view : views) {
    for (int i = 0; i < kPointsPerView / 10; ++i) {
      view.points.emplace_back(-0.06F, along(random), along(random));
    }
  }
  const std::vector<double> beside_m = ViewOffsets_m(views, can, Pose::Identity(), {});
  for (int v = 0; v < 3; ++v) EXPECT_NEAR(beside_m[v], alone_m[v], kTolerance_m) << v;
}

TEST(ViewOffsetsTest, ShapesWithoutSizesAndSensorsWithoutWarpHaveNone) {
  const std::vector<double> none(3, 0);
  const Shape ball = Sphere{.radius_m = 0.045};
  const std::vector<BodyView> views = ViewsOf(ball, Pose::Identity(), 0.06, kOffsets_m);
  EXPECT_EQ(ViewOffsets_m(views, ball, Pose::Identity(), {.model = SensorModel::kTiltingLaser}),
            none);
  const Shape capsule = Capsule{.radius_m = 0.045, .length_m = 0.001};
  EXPECT_FALSE(HasViewOffsets(capsule));
  EXPECT_EQ(ViewOffsets_m(views, capsule, Pose::Identity(), {}), none);
}

}  // namespace
}  // namespace cwm::perception
