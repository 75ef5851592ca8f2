// Clouds that no scene makes: each is segmented without losing count of a point.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

enum class Layout { kUnorganised, kImage };

// Segments the points and checks that each finite point is in exactly one place.
void ExpectAllCounted(std::vector<Vector3f> points, Layout layout = Layout::kUnorganised) {
  PointCloud cloud;
  cloud.width = static_cast<int>(points.size());
  if (layout == Layout::kImage) {
    ASSERT_EQ(points.size() % 10, 0u);
    cloud.width = static_cast<int>(points.size() / 10);
    cloud.height = 10;
  }
  cloud.points = std::move(points);
  auto measured = CollectMeasured(cloud, {});
  ASSERT_TRUE(measured.ok());
  const std::size_t finite = measured->oriented.size();
  const auto scene = SegmentScene(*std::move(measured), {}, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  std::vector<int> owners(finite, 0);
  for (const auto& support : scene->supports) {
    for (std::uint32_t i : support.points) ++owners[i];
  }
  for (const auto& hypothesis : scene->hypotheses) {
    EXPECT_FALSE(hypothesis.points.empty());
    for (std::uint32_t i : hypothesis.points) ++owners[i];
  }
  for (std::uint32_t i : scene->rejected) ++owners[i];
  for (int count : owners) ASSERT_EQ(count, 1);
  EXPECT_LE(static_cast<double>(scene->rejected.size()), 0.005 * static_cast<double>(finite));
}

TEST(DegenerateClouds, OnePoint) { ExpectAllCounted({{0.1f, 0.2f, 1}}); }

TEST(DegenerateClouds, NextToTheSensor) { ExpectAllCounted({{1e-6f, 0, 0}, {0, 0, 1e-6f}}); }

TEST(DegenerateClouds, AThousandEqualPoints) {
  ExpectAllCounted(std::vector<Vector3f>(1000, Vector3f(0.1f, 0, 1)));
  ExpectAllCounted(std::vector<Vector3f>(1000, Vector3f(0.1f, 0, 1)), Layout::kImage);
}

TEST(DegenerateClouds, ManyEqualPoints) {
  ExpectAllCounted(std::vector<Vector3f>(200000, Vector3f(0.1f, 0, 1)));
}

TEST(DegenerateClouds, ALine) {
  std::vector<Vector3f> points;
  for (int i = 0; i < 2000; ++i) points.push_back({0.001f * static_cast<float>(i), 0, 1});
  ExpectAllCounted(points);
  ExpectAllCounted(points, Layout::kImage);
}

TEST(DegenerateClouds, ASphere) {
  std::mt19937 random(5);
  std::normal_distribution<float> draw;
  std::vector<Vector3f> points;
  for (int i = 0; i < 20000; ++i) {
    const Vector3f d = Vector3f(draw(random), draw(random), draw(random)).normalized();
    points.push_back(Vector3f(0, 0, 1) + 0.1f * d);
  }
  ExpectAllCounted(points);
}

TEST(DegenerateClouds, NoiseThatFillsARoom) {
  std::mt19937 random(6);
  std::uniform_real_distribution<float> draw(-50, 50);
  std::vector<Vector3f> points;
  for (int i = 0; i < 20000; ++i) points.push_back({draw(random), draw(random), draw(random)});
  ExpectAllCounted(points);
  ExpectAllCounted(points, Layout::kImage);
}

// Planes fit the noise, but it has no surface.
TEST(DegenerateClouds, DenseNoiseHoldsNoSupport) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> draw(-0.6f, 0.6f);
  PointCloud cloud;
  for (int i = 0; i < 200000; ++i) {
    cloud.points.push_back({draw(random), draw(random), 2 + draw(random)});
  }
  cloud.width = static_cast<int>(cloud.size());
  const auto scene = SegmentScene(*CollectMeasured(cloud, {}), {}, {});
  ASSERT_TRUE(scene.ok());
  EXPECT_TRUE(scene->supports.empty());
}

TEST(DegenerateClouds, PointsAtTheLargestCoordinate) {
  ExpectAllCounted({{1e6f, 0, 0}, {-1e6f, 1e6f, 0}, {0, 0, 1e6f}, {0, 0, 1}});
}

TEST(DegenerateClouds, APlaneThatFillsTheViewIsOneSupport) {
  PointCloud cloud;
  cloud.width = 160;
  cloud.height = 120;
  for (int v = 0; v < 120; ++v) {
    for (int u = 0; u < 160; ++u) {
      const Vector3f ray((static_cast<float>(u) - 80) / 130, (static_cast<float>(v) - 60) / 130, 1);
      const Vector3f normal(0, -0.7071f, -0.7071f);
      cloud.points.push_back(ray * (0.8f * normal.z() / normal.dot(ray)));
    }
  }
  const auto scene = SegmentScene(*CollectMeasured(cloud, {}), {}, {});
  ASSERT_TRUE(scene.ok());
  ASSERT_EQ(scene->supports.size(), 1u);
  EXPECT_TRUE(scene->hypotheses.empty());
  EXPECT_EQ(scene->supports[0].points.size(), cloud.size());
}

}  // namespace
}  // namespace cwm::perception
