#include "perception/track/range_view.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kTolerance_m = 0.01;

// A ball of 10 cm radius at 1 m, in front of a wall at 2 m.
PointCloud BallBeforeWall() {
  SimulatedScene scene;
  scene.objects.push_back({.name = "ball", .parts = {{.shape = Sphere{.radius_m = 0.1}}}});
  scene.objects[0].X_WO = MakeTranslation(0, 0, 1);
  scene.objects.push_back({.name = "wall", .parts = {{.shape = HalfSpace{}}}});
  scene.objects[1].X_WO = MakePose({0, 0, 2}, Quaternion(0, 1, 0, 0));  // solid beyond z = 2
  return Scan(scene, PinholeCamera(), {.noiseless = true}).cloud;
}

PointCloud Unorganised(PointCloud cloud) {
  cloud.width = static_cast<int>(cloud.points.size());
  cloud.height = 1;
  return cloud;
}

TEST(EstimatePinhole, RecoversTheCamera) {
  const auto pinhole = EstimatePinhole(BallBeforeWall());
  ASSERT_TRUE(pinhole);
  // Coordinates are floats: 1e-7 of 640 pixels.
  EXPECT_NEAR(pinhole->focal_u_px, 525, 0.01);
  EXPECT_NEAR(pinhole->focal_v_px, 525, 0.01);
  EXPECT_NEAR(pinhole->center_u_px, 319.5, 0.01);
  EXPECT_NEAR(pinhole->center_v_px, 239.5, 0.01);
}

TEST(EstimatePinhole, RefusesWhatIsNoImage) {
  EXPECT_FALSE(EstimatePinhole(Unorganised(BallBeforeWall())));
  PointCloud reversed = BallBeforeWall();
  std::swap(reversed.width, reversed.height);  // rows of another length
  EXPECT_FALSE(EstimatePinhole(reversed));
  PointCloud behind = BallBeforeWall();
  for (auto& p : behind.points) p.z() = -p.z();
  EXPECT_FALSE(EstimatePinhole(behind));
  PointCloud nothing = BallBeforeWall();
  for (auto& p : nothing.points) p.setConstant(std::nanf(""));
  EXPECT_FALSE(EstimatePinhole(nothing));
}

void ExpectSights(const RangeView& view) {
  EXPECT_EQ(view.VerdictAt({0, 0, 0.9}, kTolerance_m), RayVerdict::kHit);
  EXPECT_EQ(view.VerdictAt({0, 0, 0.905}, kTolerance_m), RayVerdict::kHit);
  EXPECT_EQ(view.VerdictAt({0, 0, 0.88}, kTolerance_m), RayVerdict::kThrough);
  EXPECT_EQ(view.VerdictAt({0, 0, 0.92}, kTolerance_m), RayVerdict::kHidden);
  EXPECT_EQ(view.VerdictAt({0, 0, 1.99}, kTolerance_m), RayVerdict::kHidden);
  EXPECT_EQ(view.VerdictAt({0.4, 0.3, 1.5}, kTolerance_m), RayVerdict::kThrough);
  EXPECT_EQ(view.VerdictAt({0.4, 0.3, 2}, kTolerance_m), RayVerdict::kHit);
  EXPECT_EQ(view.VerdictAt({0.4, 0.3, 2.1}, kTolerance_m), RayVerdict::kHidden);
  EXPECT_EQ(view.VerdictAt({3, 0, 1}, kTolerance_m), RayVerdict::kUnknown);
  EXPECT_EQ(view.VerdictAt({0, 0, -1}, kTolerance_m), RayVerdict::kUnknown);
}

TEST(RangeView, TellsHitHiddenThroughAndUnknownOfAnImage) {
  ExpectSights(RangeView(BallBeforeWall()));
}

TEST(RangeView, TellsTheSameOfAnUnorganisedCloud) {
  ExpectSights(RangeView(Unorganised(BallBeforeWall())));
}

TEST(RangeView, TellsTheSameOnEveryFaceOfTheCube) {
  for (int face = 0; face < 6; ++face) {
    Matrix3 R = Matrix3::Identity();
    if (face < 4) R = Eigen::AngleAxisd(face * M_PI / 2, Vector3::UnitY()).toRotationMatrix();
    if (face >= 4) {
      R = Eigen::AngleAxisd((face - 4.5) * M_PI, Vector3::UnitX()).toRotationMatrix();
    }
    PointCloud cloud = Unorganised(BallBeforeWall());
    for (auto& p : cloud.points) p = R.cast<float>() * p;
    const RangeView view(cloud);
    EXPECT_EQ(view.VerdictAt(R * Vector3(0, 0, 0.9), kTolerance_m), RayVerdict::kHit) << face;
    EXPECT_EQ(view.VerdictAt(R * Vector3(0.4, 0.3, 1.5), kTolerance_m), RayVerdict::kThrough)
        << face;
    EXPECT_EQ(view.VerdictAt(R * Vector3(0, 0, 0.95), kTolerance_m), RayVerdict::kHidden) << face;
    EXPECT_EQ(view.VerdictAt(R * Vector3(0, 0, -1), kTolerance_m), RayVerdict::kUnknown) << face;
  }
}

TEST(RangeView, KnowsNothingWhereNothingReturned) {
  PointCloud cloud = BallBeforeWall();
  for (auto& p : cloud.points) p.setConstant(std::nanf(""));
  EXPECT_EQ(RangeView(cloud).VerdictAt({0, 0, 1}, kTolerance_m), RayVerdict::kUnknown);
  EXPECT_EQ(RangeView(PointCloud()).VerdictAt({0, 0, 1}, kTolerance_m), RayVerdict::kUnknown);
}

}  // namespace
}  // namespace cwm::perception
