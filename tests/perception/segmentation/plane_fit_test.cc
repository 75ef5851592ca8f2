#include "perception/segmentation/plane_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr float kSigma_m = 0.002f;

// `inliers` points of the plane z = 0.5 within a square metre, then `outliers` anywhere above it.
OrientedPoints NoisyPlane(int inliers, int outliers) {
  std::mt19937 random(11);
  std::normal_distribution<float> noise(0, kSigma_m);
  std::uniform_real_distribution<float> across(-0.5f, 0.5f), above(0.05f, 0.5f);
  OrientedPoints points;
  for (int i = 0; i < inliers + outliers; ++i) {
    const float z = 0.5f + (i < inliers ? noise(random) : above(random));
    points.points.push_back({across(random), across(random), z});
    points.normals.push_back(Vector3f::UnitZ());
    points.sigma_m.push_back(kSigma_m);
  }
  return points;
}

std::vector<std::uint32_t> All(const OrientedPoints& points) {
  std::vector<std::uint32_t> members(points.size());
  std::iota(members.begin(), members.end(), 0u);
  return members;
}

TEST(FitPlane, RecoversThePlaneWithinThreeSigmaDespiteFortyPercentOutliers) {
  constexpr int kInliers = 600;
  const OrientedPoints points = NoisyPlane(kInliers, 400);
  const auto plane = FitPlane(points, All(points), 1);
  ASSERT_TRUE(plane);
  // Offset at the middle: sigma / sqrt(n); slope: sigma / (sqrt(n) times the rms lever of 0.29 m).
  const double offset_sigma = kSigma_m / std::sqrt(double{kInliers});
  EXPECT_NEAR(plane->Height_m(Vector3(0, 0, 0.5)), 0, 3 * offset_sigma);
  EXPECT_LT(std::acos(std::min(1.0, plane->normal.z())), 3 * std::sqrt(2.0) * offset_sigma / 0.29);
}

TEST(FitPlane, FindsNothingOnALineOrInOnePlace) {
  OrientedPoints line;
  for (int i = 0; i < 100; ++i) {
    line.points.push_back({0.01f * static_cast<float>(i), 0, 1});
    line.normals.push_back(Vector3f::UnitZ());
    line.sigma_m.push_back(kSigma_m);
  }
  EXPECT_FALSE(FitPlane(line, All(line), 1));
  for (Vector3f& p : line.points) p = {1, 1, 1};
  EXPECT_FALSE(FitPlane(line, All(line), 1));
  EXPECT_FALSE(FitPlane(line, {}, 1));
}

TEST(FitPlane, RefusesSamplesWhoseNormalsContradictThePlane) {
  OrientedPoints points = NoisyPlane(500, 0);
  for (Vector3f& n : points.normals) n = Vector3f::UnitX();
  EXPECT_FALSE(FitPlane(points, All(points), 1));
}

}  // namespace
}  // namespace cwm::perception
