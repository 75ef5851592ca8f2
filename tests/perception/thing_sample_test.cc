#include "perception/thing_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// One thing of `count` points along the x axis, evenly spread over a metre.
SegmentedScene Row(std::size_t count, std::size_t nodes) {
  SegmentedScene scene;
  SegmentedThing& thing = scene.things.emplace_back();
  for (std::uint32_t i = 0; i < count; ++i) {
    scene.points.points.emplace_back(static_cast<float>(i) / static_cast<float>(count), 0, 1);
    scene.points.normals.emplace_back(0, 0, 1);
    scene.points.sigma_m.push_back(0.01f);
    scene.points.normal_sigma_rad.push_back(0.1f);
    scene.points.cloud_index.push_back(i);
    thing.points.push_back(i);
  }
  thing.node_count = nodes;
  return scene;
}

TEST(ThingSample, IsAllOfAnImagesPointsHoweverMany) {
  const SegmentedScene scene = Row(400'000, 400'000);
  const ThingSample sample(scene, scene.things[0]);
  EXPECT_EQ(sample.stride(), 1u);
  EXPECT_EQ(sample.Points().points, scene.points.points);
}

TEST(ThingSample, IsAllOfASmallThingHoweverDense) {
  const SegmentedScene scene = Row(120'000, 10);
  EXPECT_EQ(ThingSample(scene, scene.things[0]).stride(), 1u);
}

TEST(ThingSample, OfADenseThingGrowsWithItsNodesAndNotWithItsPoints) {
  for (const std::size_t count : {400'000u, 800'000u}) {
    const SegmentedScene scene = Row(count, 20'000);
    const std::size_t sampled = ThingSample(scene, scene.things[0]).Points().size();
    EXPECT_EQ(sampled, 80'000u) << count;  // four a node
  }
}

TEST(ThingSample, GivesEachPointThePartOfTheSampledOneNearestToIt) {
  const SegmentedScene scene = Row(400'003, 10);  // no multiple of the stride
  const ThingSample sample(scene, scene.things[0]);
  ASSERT_GT(sample.stride(), 4u);
  const OrientedPoints sampled = sample.Points();
  std::vector<std::int32_t> part;
  for (const Vector3f& p : sampled.points) part.push_back(p.x() < 0.3f ? 0 : -1);
  const std::vector<std::int32_t> all = sample.OfAll(part, kUnbounded);
  ASSERT_EQ(all.size(), scene.points.size());
  const float step = 0.5f * static_cast<float>(sample.stride()) / 400'003;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const float x = scene.points.points[i].x();
    if (std::abs(x - 0.3f) <= step) continue;  // either may be the nearer
    EXPECT_EQ(all[i], x < 0.3f ? 0 : -1) << "at " << x;
  }
}

TEST(ThingSample, CountsScaleToAllPoints) {
  const SegmentedScene scene = Row(400'003, 10);
  const ThingSample sample(scene, scene.things[0]);
  EXPECT_EQ(sample.Scaled(sample.Points().size()), 400'003u);
  EXPECT_EQ(sample.Scaled(0), 0u);
}

}  // namespace
}  // namespace cwm::perception
