#include "perception/segmentation/level_patches.h"

#include <gtest/gtest.h>

#include <random>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr float kRangeSigma_m = 0.0025f;
constexpr float kGrazingNoise_sigma = 4;  // of a Kinect at ten degrees

// Adds points whose normals face the sensor at the origin, with noise along the ray.
void AddPoints(const Vector3f& corner, const Vector3f& along, const Vector3f& across,
               float noise_sigma, OrientedPoints& points) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> share(0, 1);
  std::normal_distribution<float> noise(0, noise_sigma * kRangeSigma_m);
  for (int i = 0; i < 6000; ++i) {
    const Vector3f p = corner + share(random) * along + share(random) * across;
    points.points.push_back(p + noise(random) * p.normalized());
    points.normals.push_back(-p.normalized());
    points.sigma_m.push_back(kRangeSigma_m);
    points.normal_sigma_rad.push_back(0.1f);
    points.cloud_index.push_back(static_cast<std::uint32_t>(i));
  }
}

// The share of the cells whose normals are turned upright.
double TurnedShare(const OrientedPoints& points) {
  CoarseCloud coarse = MakeCoarseCloud(points);
  const ReorientedCells turned = ReorientLevelPatches(Vector3f::UnitZ(), coarse, {});
  for (std::uint32_t c : turned) EXPECT_GT(coarse.cells.normals[c].z(), 0.97f);
  return static_cast<double>(turned.size()) / static_cast<double>(coarse.cells.size());
}

TEST(LevelPatches, OfABoardThatOneLooksAlongAreTurnedUp) {
  OrientedPoints points;
  AddPoints({1.2f, -0.4f, -0.2f}, {0.25f, 0, 0}, {0, 0.8f, 0}, kGrazingNoise_sigma, points);
  EXPECT_GT(TurnedShare(points), 0.8);
}

TEST(LevelPatches, OfAWallAtTheSameHeightOrAStripOfItAreNot) {
  OrientedPoints wall, strip;
  AddPoints({1.2f, -0.4f, -0.4f}, {0, 0, 0.4f}, {0, 0.8f, 0}, 1, wall);
  EXPECT_EQ(TurnedShare(wall), 0);
  AddPoints({1.2f, -0.4f, -0.2f}, {0, 0, 0.006f}, {0, 0.8f, 0}, 1, strip);
  EXPECT_LT(TurnedShare(strip), 0.05);
}

TEST(LevelPatches, OfASlopeOfTwentyDegreesAreNot) {
  OrientedPoints points;
  AddPoints({1.2f, -0.4f, -0.2f}, {0.25f, 0, 0.09f}, {0, 0.8f, 0}, 1, points);
  EXPECT_EQ(TurnedShare(points), 0);
}

TEST(LevelPatches, OfABoardAboveTheSensorAreNot) {
  OrientedPoints points;
  AddPoints({1.2f, -0.4f, 0.2f}, {0.25f, 0, 0}, {0, 0.8f, 0}, kGrazingNoise_sigma, points);
  EXPECT_EQ(TurnedShare(points), 0);
}

}  // namespace
}  // namespace cwm::perception
