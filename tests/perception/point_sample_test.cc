#include "perception/hypotheses/point_sample.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

// `count` points of one object, evenly spread over a metre of the x axis.
struct Row {
  OrientedPoints points;
  PointSet members;
  std::size_t nodes = 0;

  PointSample Sample() const { return {points, members, nodes}; }
};

Row MakeRow(std::size_t count, std::size_t nodes) {
  Row row;
  for (std::uint32_t i = 0; i < count; ++i) {
    row.points.points.emplace_back(static_cast<float>(i) / static_cast<float>(count), 0, 1);
    row.points.normals.emplace_back(0, 0, 1);
    row.points.sigma_m.push_back(0.01f);
    row.points.normal_sigma_rad.push_back(0.1f);
    row.points.cloud_index.push_back(i);
    row.members.push_back(i);
  }
  row.nodes = nodes;
  return row;
}

TEST(PointSample, IsAllOfAnImagesPointsHoweverMany) {
  const Row row = MakeRow(400'000, 400'000);
  const PointSample sample = row.Sample();
  EXPECT_EQ(sample.stride(), 1u);
  EXPECT_EQ(sample.Points().points, row.points.points);
}

TEST(PointSample, IsAllOfASmallObjectHoweverDense) {
  const Row row = MakeRow(120'000, 10);
  EXPECT_EQ(row.Sample().stride(), 1u);
}

TEST(PointSample, OfADenseObjectGrowsWithItsNodesAndNotWithItsPoints) {
  for (const std::size_t count : {400'000u, 800'000u}) {
    const Row row = MakeRow(count, 20'000);
    const std::size_t sampled = row.Sample().Points().size();
    EXPECT_EQ(sampled, 80'000u) << count;  // four per graph node
  }
}

TEST(PointSample, GivesEachPointThePartOfTheSampledOneNearestToIt) {
  const Row row = MakeRow(400'003, 10);  // no multiple of the stride
  const PointSample sample = row.Sample();
  ASSERT_GT(sample.stride(), 4u);
  const OrientedPoints sampled = sample.Points();
  std::vector<std::int32_t> part;
  for (const Vector3f& p : sampled.points) part.push_back(p.x() < 0.3f ? 0 : -1);
  const std::vector<std::int32_t> all = sample.PartsOfAllPoints(part, kSerialWork);
  ASSERT_EQ(all.size(), row.points.size());
  const float step = 0.5f * static_cast<float>(sample.stride()) / 400'003;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const float x = row.points.points[i].x();
    if (std::abs(x - 0.3f) <= step) continue;  // either may be the nearer
    EXPECT_EQ(all[i], x < 0.3f ? 0 : -1) << "at " << x;
  }
}

TEST(PointSample, CountsScaleToAllPoints) {
  const Row row = MakeRow(400'003, 10);
  const PointSample sample = row.Sample();
  EXPECT_EQ(sample.Scaled(sample.Points().size()), 400'003u);
  EXPECT_EQ(sample.Scaled(0), 0u);
}

}  // namespace
}  // namespace cwm::perception
