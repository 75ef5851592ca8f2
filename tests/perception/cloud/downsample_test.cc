#include "perception/cloud/downsample.h"

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

OrientedPoints PointsOf(const std::vector<Eigen::Vector3f>& positions,
                        const std::vector<Eigen::Vector3f>& normals) {
  OrientedPoints points;
  points.points = positions;
  points.normals = normals;
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    points.sigma_m.push_back(0.001f * static_cast<float>(i + 1));
    points.normal_sigma_rad.push_back(0.1f * static_cast<float>(i + 1));
    points.cloud_index.push_back(10 + i);
  }
  points.viewpoint = Vector3(1, 2, 3);
  return points;
}

TEST(Downsample, GivesEachCellTheMeansOfItsPoints) {
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), z = Eigen::Vector3f::UnitZ();
  // Two points in one cell of 10 cm, one in another.
  const OrientedPoints points = PointsOf({{0, 0, 0}, {0.04f, 0.02f, 0}, {0.25f, 0, 0}}, {x, z, z});
  const OrientedPoints cells = Downsample(points, VoxelGrid::Build(points.points, 0.1f));
  ASSERT_EQ(cells.size(), 2u);
  EXPECT_TRUE(cells.points[0].isApprox(Eigen::Vector3f(0.02f, 0.01f, 0), 1e-5f));
  EXPECT_TRUE(cells.normals[0].isApprox((x + z).normalized(), 1e-6f));
  EXPECT_FLOAT_EQ(cells.sigma_m[0], 0.0015f);
  EXPECT_FLOAT_EQ(cells.normal_sigma_rad[0], 0.15f);
  EXPECT_EQ(cells.cloud_index[0], 10u);
  EXPECT_EQ(cells.cloud_index[1], 12u);
  EXPECT_EQ(cells.viewpoint, points.viewpoint);
}

TEST(Downsample, LeavesNormalsThatCancelUnknown) {
  const Eigen::Vector3f z = Eigen::Vector3f::UnitZ();
  const OrientedPoints points = PointsOf({{0, 0, 0}, {0.01f, 0, 0}}, {z, -z});
  const OrientedPoints cells = Downsample(points, VoxelGrid::Build(points.points, 0.1f));
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_TRUE(cells.normals[0].isZero());
}

TEST(Downsample, OfNothingIsNothing) {
  EXPECT_EQ(Downsample({}, VoxelGrid::Build({}, 0.1f)).size(), 0u);
}

}  // namespace
}  // namespace cwm::perception
