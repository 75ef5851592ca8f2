// Rays that passed an object show where it is not.
#include "perception/fit/passing_rays.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

const Vector3 kEye(-0.8, 0, 0.8);
constexpr float kSigma_m = 0.0015f;
constexpr double kHeight_m = 0.1, kRadius_m = 0.04;  // of the visible disc, above z = 0

ModelPoints DiscAtHeight() {
  OrientedPoints points;
  points.viewpoint = kEye;
  for (int i = -8; i <= 8; ++i) {
    for (int j = -8; j <= 8; ++j) {
      const Eigen::Vector3f p(0.005f * static_cast<float>(i), 0.005f * static_cast<float>(j),
                              static_cast<float>(kHeight_m));
      if (p.head<2>().norm() > static_cast<float>(kRadius_m)) continue;
      points.points.push_back(p);
      points.normals.push_back(Eigen::Vector3f::UnitZ());
      points.sigma_m.push_back(kSigma_m);
      points.normal_sigma_rad.push_back(0.05f);
      points.cloud_index.push_back(0);
    }
  }
  return SubsampleForSearch(points, 4000);
}

Ground LevelGround(const ModelPoints& points) {
  return {.known = true, .up = Vector3::UnitZ(), .point = -points.origin_L};
}

PassingRays To(const Eigen::Vector3f& end) {
  return {.ends = {end}, .sigma_m = {kSigma_m}, .weight = 7};
}

Pose StandsAtOrigin(const ModelPoints& points) {
  Pose X_SM = Pose::Identity();  // of a solid as high as the disc, its origin half-way up
  X_SM.translation() = points.origin_L - Vector3(0, 0, 0.5 * kHeight_m);
  return X_SM;
}

TEST(FreeRaysPast, KeepPlacesOnTheRayBeforeItsEnd) {
  const ModelPoints points = DiscAtHeight();
  const Eigen::Vector3f end(0.03f, 0, 0);
  const FreeRays free = FreeRaysPast(points, LevelGround(points), To(end));
  ASSERT_EQ(free.rays.size(), 1U);
  EXPECT_EQ(free.weight, 7);
  const Vector3 along = (end.cast<double>() - kEye).normalized();
  for (const Vector3& p : free.rays.front().p) {
    const Vector3 away = p + points.origin_L - kEye;
    EXPECT_LT(away.cross(along).norm(), 1e-9);
    EXPECT_LT(away.dot(along), (end.cast<double>() - kEye).norm() - 3 * kSigma_m);
  }
}

TEST(FreeRaysPast, LeaveOutThoseThatEndBeforeTheObjectOrPassFarAway) {
  const ModelPoints points = DiscAtHeight();
  const Eigen::Vector3f before(-0.4f, 0, 0.4f), beside(0, 0.5f, 0);
  EXPECT_TRUE(FreeRaysPast(points, LevelGround(points), To(before)).rays.empty());
  EXPECT_TRUE(FreeRaysPast(points, LevelGround(points), To(beside)).rays.empty());
}

TEST(FreeRaysPast, AskForAGround) {
  const ModelPoints points = DiscAtHeight();
  EXPECT_TRUE(FreeRaysPast(points, {}, To(Eigen::Vector3f(0.03f, 0, 0))).rays.empty());
}

TEST(FreeRaysPast, ThinManyAndKeepTheirWeight) {
  const ModelPoints points = DiscAtHeight();
  PassingRays many;
  for (int k = 0; k < 4000; ++k) {
    many.ends.emplace_back(0.03f, 2.5e-6f * static_cast<float>(k), 0.0f);
    many.sigma_m.push_back(kSigma_m);
  }
  many.around_count = 4000;
  const FreeRays around = FreeRaysPast(points, LevelGround(points), many);
  EXPECT_LE(around.rays.size(), 320U);
  EXPECT_GT(around.rays.size(), 160U);
  EXPECT_NEAR(around.weight * static_cast<double>(around.rays.size()), 4000, around.weight);
  many.around_count = 400;  // the others are below: as dense as these, apart from their number
  const FreeRays below = FreeRaysPast(points, LevelGround(points), many);
  EXPECT_LE(below.rays.size(), 960U);
  EXPECT_GT(below.rays.size(), 2 * around.rays.size());
  EXPECT_NEAR(below.weight * static_cast<double>(below.rays.size()), 4000, below.weight);
}

TEST(ResampledAround, KeepsToTheRayAndToWhereItIsFree) {
  const ModelPoints points = DiscAtHeight();
  const FreeRays free = FreeRaysPast(points, LevelGround(points), To(Eigen::Vector3f(0, 0.03f, 0)));
  ASSERT_EQ(free.rays.size(), 1U);
  const FreeRay& ray = free.rays.front();
  const Vector3 way = (ray.p.back() - ray.p.front()).normalized();
  for (const Vector3& p : {ray.p.front(), ray.p[2], ray.p.back()}) {
    const FreeRay placed = ResampledAround(p, ray);
    EXPECT_EQ(placed.sigma_m, ray.sigma_m);
    for (const Vector3& place : placed.p) {
      const double along_m = way.dot(place - ray.p.front());
      EXPECT_LT((place - ray.p.front() - along_m * way).norm(), 1e-12);
      EXPECT_GE(along_m, -1e-12);
      EXPECT_LE(along_m, (ray.p.back() - ray.p.front()).norm() + 1e-12);
      EXPECT_LT((place - p).norm(), 0.03);
    }
  }
}

TEST(MayComeNear, AsksForThePartOfTheLineThatTheRayIs) {
  FreeRay ray{.p = {}, .sigma_m = kSigma_m};
  for (int k = 0; k < kSamplesPerRay; ++k) ray.p[static_cast<std::size_t>(k)] = {0.1 * k, 0, 0};
  EXPECT_TRUE(MayComeNear({0.25, 0.04, 0}, 0.05, ray));
  EXPECT_FALSE(MayComeNear({0.25, 0.06, 0}, 0.05, ray));
  EXPECT_FALSE(MayComeNear({-0.06, 0, 0}, 0.05, ray)) << "before it begins";
  EXPECT_FALSE(MayComeNear({0.56, 0, 0}, 0.05, ray)) << "behind its end";
  EXPECT_TRUE(MayComeNear({0.54, 0, 0}, 0.05, ray));
}

// A pole as thick as the distance between two sample positions of the ray: neither position has to
// lie in it.
TEST(FindNearestRayPoint, FindsTheDeepestPlaceBetweenTheOnesGiven) {
  FreeRay ray;
  for (int k = 0; k < kSamplesPerRay; ++k) {
    ray.p[static_cast<std::size_t>(k)] = Vector3(0.05 * k - 0.12, 0.004, 0);
  }
  const Shape pole = Cylinder{.radius_m = 0.01, .length_m = 1};
  const NearestRayPoint in =
      FindNearestRayPoint(DistanceToShape(pole), Pose(Eigen::Translation3d(-0.01, 0, 0)), ray);
  EXPECT_NEAR(in.clearance_m, -0.006, 1e-5);
  EXPECT_NEAR(in.p.x(), 0.01, 5e-4);
  const NearestRayPoint out =
      FindNearestRayPoint(DistanceToShape(pole), Pose(Eigen::Translation3d(0, 0.02, 0)), ray);
  EXPECT_NEAR(out.clearance_m, 0.014, 1e-5);
}

// The ray meets the ground beside the foot of a cup and inside the foot of a can with the same top.
TEST(FindNearestRayPoint, IsNegativeInTheCanThatTheRayCrossesAndNotInTheCup) {
  const ModelPoints points = DiscAtHeight();
  const FreeRays free = FreeRaysPast(points, LevelGround(points), To(Eigen::Vector3f(0, 0.03f, 0)));
  ASSERT_EQ(free.rays.size(), 1U);
  const Pose X_SM = StandsAtOrigin(points);
  const Shape can = Cylinder{.radius_m = kRadius_m, .length_m = kHeight_m};
  EXPECT_LT(FindNearestRayPoint(DistanceToShape(can), X_SM, free.rays.front()).clearance_m, -0.005);
  const Shape thin = Cone{.radius_bottom_m = 0.005, .radius_top_m = 0.005, .length_m = kHeight_m};
  EXPECT_GT(FindNearestRayPoint(DistanceToShape(thin), X_SM, free.rays.front()).clearance_m, 0);
}

}  // namespace
}  // namespace cwm::perception
