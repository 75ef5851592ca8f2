#include "perception/surface/thinning.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cwm::perception {
namespace {

constexpr float kSpacing_m = 0.01f;

std::vector<Eigen::Vector3f> RandomPoints(int count) {
  std::mt19937 random(5);
  const auto coordinate = [&] { return 0.1f * static_cast<float>(random() >> 8) * 0x1.0p-24f; };
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    const float x = coordinate(), y = coordinate(), z = coordinate();
    points.emplace_back(x, y, 0.3f * z);
  }
  return points;
}

TEST(Thin, KeepsVerticesApart) {
  const ThinnedPoints thinned = Thin(RandomPoints(3000), kSpacing_m);
  ASSERT_GT(thinned.vertices.size(), 100u);
  for (std::size_t i = 0; i < thinned.vertices.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      EXPECT_GE((thinned.vertices[i] - thinned.vertices[j]).norm(), kMinVertexGap * kSpacing_m);
    }
  }
}

TEST(Thin, GivesEveryPointAVertexBesideIt) {
  const std::vector<Eigen::Vector3f> points = RandomPoints(3000);
  const ThinnedPoints thinned = Thin(points, kSpacing_m);
  ASSERT_EQ(thinned.vertex_of_cell.size(), thinned.grid.size());
  // The diagonal of the point's cell, which also contains the cell's centroid, plus the distance
  // from the centroid to the vertex that was kept in its place.
  const double farthest_m = (std::sqrt(3.0) + kMinVertexGap) * kSpacing_m;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int32_t vertex = thinned.vertex_of_cell[thinned.grid.CellOfPoint(i)];
    ASSERT_GE(vertex, 0);
    ASSERT_LT(static_cast<std::size_t>(vertex), thinned.vertices.size());
    EXPECT_LE((thinned.vertices[static_cast<std::size_t>(vertex)] - points[i]).norm(), farthest_m);
  }
}

TEST(Thin, OfNothingIsNothing) { EXPECT_TRUE(Thin({}, kSpacing_m).vertices.empty()); }

}  // namespace
}  // namespace cwm::perception
