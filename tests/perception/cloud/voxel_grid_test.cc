#include "perception/cloud/voxel_grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>
#include <random>

#include "perception/cloud/morton.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

std::vector<Vector3f> RandomPoints(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> coordinate(-0.5f, 0.5f);
  std::vector<Vector3f> points(count);
  for (Vector3f& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
  return points;
}

TEST(VoxelGrid, HoldsEachPointOnceInTheCellThatContainsIt) {
  const std::vector<Vector3f> points = RandomPoints(5000);
  const VoxelGrid grid = VoxelGrid::Build(points, 0.1f);
  std::vector<int> seen(points.size(), 0);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    EXPECT_EQ(grid.Find(grid.cell(c)), static_cast<std::int32_t>(c));
    for (std::uint32_t i : grid.PointsOf(c)) {
      ++seen[i];
      EXPECT_EQ(grid.CellOfPoint(i), c);
      EXPECT_LE((points[i] - grid.Center(c)).cwiseAbs().maxCoeff(), 0.05f + 1e-5f);
    }
  }
  EXPECT_THAT(seen, ::testing::Each(1));
}

TEST(VoxelGrid, KeepsItsCellsWhenItsPointsAreBroughtIntoTheirOrder) {
  const std::vector<Vector3f> points = RandomPoints(5000);
  const VoxelGrid before = VoxelGrid::Build(points, 0.1f);
  VoxelGrid after = before;
  const std::vector<std::uint32_t> number_before = after.Renumber();
  ASSERT_EQ(number_before.size(), points.size());
  ASSERT_EQ(after.size(), before.size());
  std::uint32_t next = 0;
  for (std::size_t c = 0; c < after.size(); ++c) {
    EXPECT_EQ(after.cell(c), before.cell(c));
    ASSERT_EQ(after.PointsOf(c).size(), before.PointsOf(c).size());
    for (std::size_t k = 0; k < after.PointsOf(c).size(); ++k) {
      EXPECT_EQ(after.PointsOf(c)[k], next);
      EXPECT_EQ(after.CellOfPoint(next), c);
      EXPECT_EQ(number_before[next], before.PointsOf(c)[k]);
      ++next;
    }
  }
}

TEST(VoxelGrid, MomentsMatchTheDirectSums) {
  const std::vector<Vector3f> points = RandomPoints(2000);
  const VoxelGrid grid = VoxelGrid::Build(points, 0.25f);
  ASSERT_GT(grid.size(), 10u);
  for (std::size_t c = 0; c < grid.size(); ++c) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (std::uint32_t i : grid.PointsOf(c)) mean += points[i].cast<double>();
    mean /= static_cast<double>(grid.PointsOf(c).size());
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::uint32_t i : grid.PointsOf(c)) {
      const Eigen::Vector3d d = points[i].cast<double>() - mean;
      covariance += d * d.transpose() / static_cast<double>(grid.PointsOf(c).size());
    }
    EXPECT_TRUE(grid.Centroid(c).cast<double>().isApprox(mean, 1e-5));
    EXPECT_LT((grid.moments(c).Covariance().cast<double>() - covariance).norm(), 1e-6);
  }
}

TEST(VoxelGrid, MomentsAddUpAboutAnotherOrigin) {
  const Vector3f offset(0.3f, -0.2f, 0.1f);
  Moments about_origin, about_offset, moved;
  for (const Vector3f& p : RandomPoints(100)) {
    about_origin.Add(p);
    about_offset.Add(p - offset);
  }
  moved.Add(about_offset, offset);
  EXPECT_TRUE(moved.sum.isApprox(about_origin.sum, 1e-4f));
  EXPECT_LT((moved.Covariance() - about_origin.Covariance()).norm(), 1e-5f);
}

TEST(VoxelGrid, AMillionPointsInOnePlaceAreOneCell) {
  const std::vector<Vector3f> points(1000000, Vector3f(1, 2, 3));
  const VoxelGrid grid = VoxelGrid::Build(points, 0.004f);
  ASSERT_EQ(grid.size(), 1u);
  EXPECT_EQ(grid.moments(0).count, 1000000u);
}

TEST(VoxelGrid, WidensItsCellsForWideClouds) {
  const std::vector<Vector3f> points{{0, 0, 0}, {1e6f, 0, 0}, {-1e6f, 1e6f, 5}};
  const VoxelGrid grid = VoxelGrid::Build(points, 0.001f);
  EXPECT_EQ(grid.size(), 3u);
  EXPECT_GT(grid.edge_m(), 0.5f);
}

TEST(VoxelGrid, VisitsEachOccupiedCellWithinReachOnceAndNoOther) {
  const VoxelGrid grid = VoxelGrid::Build(RandomPoints(3000), 0.05f);  // a third of the cells
  std::vector<VoxelGrid::Cell> centers{
      {0, 0, 0}, {-2, 5, 5}, {21, 3, 22}, {-9, 0, 0}, {2097151, 4, 4}};
  for (std::size_t c = 0; c < grid.size(); c += 37) centers.push_back(grid.cell(c));
  for (const VoxelGrid::Cell& center : centers) {
    for (int reach = 0; reach <= 5; ++reach) {
      std::vector<std::size_t> expected, visited;
      for (std::size_t c = 0; c < grid.size(); ++c) {
        if ((grid.cell(c) - center).cwiseAbs().maxCoeff() <= reach) expected.push_back(c);
      }
      grid.ForEachWithin(reach, center, [&](std::size_t c) { visited.push_back(c); });
      EXPECT_THAT(visited, ::testing::UnorderedElementsAreArray(expected))
          << center.transpose() << " reach " << reach;
    }
  }
}

TEST(VoxelGrid, EndsAtTheFirstCellThatIsTakenFor) {
  const VoxelGrid grid = VoxelGrid::Build(RandomPoints(3000), 0.05f);
  int asked = 0;
  EXPECT_TRUE(grid.AnyWithin(2, grid.cell(100), [&](std::size_t) { return ++asked == 3; }));
  EXPECT_EQ(asked, 3);
  EXPECT_FALSE(grid.AnyWithin(2, grid.cell(100), [](std::size_t) { return false; }));
}

TEST(MortonKey, IsUndoneBitByBit) {
  for (const std::uint32_t v : {0u, 1u, 2u, 5u, 0x12345u, 0x1ffffeu, 0x1fffffu}) {
    EXPECT_EQ(GatherBits(MortonKey(v, 0, 0)), v);
    EXPECT_EQ(GatherBits(MortonKey(7, v, 9) >> 1), v);
    EXPECT_EQ(GatherBits(MortonKey(0x1fffff, 3, v) >> 2), v);
  }
}

TEST(VoxelGrid, FindsNothingWhereNothingIs) {
  const VoxelGrid grid = VoxelGrid::Build(RandomPoints(10), 0.01f);
  EXPECT_EQ(grid.Find({-5, 0, 0}), kNoIndex);
  // No other coordinates match those of a cell, however their bits are truncated.
  const VoxelGrid::Cell& first = grid.cell(0);
  EXPECT_EQ(grid.Find({first.x() + (1 << 21), first.y(), first.z()}), kNoIndex);
  EXPECT_EQ(grid.Find({first.x(), first.y() - (1 << 21), first.z()}), kNoIndex);
  EXPECT_EQ(VoxelGrid().Find({0, 0, 0}), kNoIndex);
}

}  // namespace
}  // namespace cwm::perception
