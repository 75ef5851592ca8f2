#include "perception/surface/projection_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>
#include <stop_token>

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;

constexpr double kApart_m = 0.01;
constexpr int kPerRow = 20;
const Eigen::AngleAxisf kTilt(0.6f, Eigen::Vector3f(1, 2, 0).normalized());

// Rows of points on a tilted plane, with every other row shifted by half a spacing and every other
// point off the plane by `off_m`. The rows begin at `begin_m`.
std::vector<Eigen::Vector3f> TiltedRows(float off_m, float begin_m = 0) {
  constexpr auto kStep_m = static_cast<float>(kApart_m);
  std::vector<Eigen::Vector3f> points;
  for (int row = 0; row < kPerRow; ++row) {
    for (int k = 0; k < kPerRow; ++k) {
      const float x_m = begin_m + kStep_m * (static_cast<float>(k) + (row % 2 == 0 ? 0 : 0.5f));
      const float z_m = (row + k) % 2 == 0 ? off_m : -off_m;
      points.push_back(kTilt * Eigen::Vector3f(x_m, kStep_m * static_cast<float>(row), z_m));
    }
  }
  return points;
}

float OffPlane_m(const Eigen::Vector3f& p) { return (kTilt.inverse() * p).z(); }

double RmsOffPlane_m(const std::vector<Eigen::Vector3f>& points) {
  double squares = 0;
  for (const Eigen::Vector3f& p : points) squares += std::pow(double{OffPlane_m(p)}, 2);
  return std::sqrt(squares / static_cast<double>(points.size()));
}

TEST(MeshByProjection, CoversAPlaneWithShortEdges) {
  const std::vector<Eigen::Vector3f> points = TiltedRows(0);
  const ProjectionMesh mesh = MeshByProjection(points, kApart_m);
  ASSERT_EQ(mesh.vertices.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LT((mesh.vertices[i] - points[i]).norm(), 1e-4f) << i;
  }
  std::set<std::array<std::uint32_t, 3>> seen;  // triangles may be repeated
  double area_m2 = 0;
  for (std::array<std::uint32_t, 3> triangle : mesh.triangles) {
    std::ranges::sort(triangle);
    ASSERT_LT(triangle[2], points.size());
    if (!seen.insert(triangle).second) continue;
    const Eigen::Vector3f a = mesh.vertices[triangle[0]], b = mesh.vertices[triangle[1]],
                          c = mesh.vertices[triangle[2]];
    area_m2 += 0.5 * double{(b - a).cross(c - a).norm()};
    const float longest_m = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    EXPECT_LE(longest_m, kMaxEdge * kApart_m * 1.001);
  }
  // Each of 19 strips of 19 steps; triangles in the notches at the rows' ends are added to that.
  const double strips_m2 = 19 * 19 * kApart_m * kApart_m;
  EXPECT_GT(area_m2, 0.9 * strips_m2);
  EXPECT_LT(area_m2, 1.1 * strips_m2);
}

TEST(MeshByProjection, SmoothsNoiseAndMovesNoVertexFar) {
  const std::vector<Eigen::Vector3f> points = TiltedRows(0.002f);
  const ProjectionMesh mesh = MeshByProjection(points, kApart_m);
  ASSERT_EQ(mesh.vertices.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_LE((mesh.vertices[i] - points[i]).norm(), kApart_m) << i;
  }
  EXPECT_LT(RmsOffPlane_m(mesh.vertices), 0.5 * RmsOffPlane_m(points));
}

TEST(MeshByProjection, BridgesNoGapThatIsWiderThanAnEdge) {
  std::vector<Eigen::Vector3f> points = TiltedRows(0);
  const auto first_of_other = static_cast<std::uint32_t>(points.size());
  // The rows of the first sheet end at 195 mm; those of the other begin four spacings from there.
  const std::vector<Eigen::Vector3f> other = TiltedRows(0, 0.235f);
  points.insert(points.end(), other.begin(), other.end());
  const ProjectionMesh mesh = MeshByProjection(points, kApart_m);
  int of_first = 0, of_other = 0;
  for (const std::array<std::uint32_t, 3>& triangle : mesh.triangles) {
    const auto in_other = std::ranges::count_if(
        triangle, [&](std::uint32_t vertex) { return vertex >= first_of_other; });
    EXPECT_TRUE(in_other == 0 || in_other == 3);
    ++(in_other == 0 ? of_first : of_other);
  }
  EXPECT_GT(of_first, 500);  // of 19 x 19 x 2
  EXPECT_GT(of_other, 500);
}

TEST(MeshByProjection, HasNoTrianglesOfTwoVerticesAndEndsWhenStopped) {
  const std::vector<Eigen::Vector3f> points = TiltedRows(0);
  for (const std::size_t count : {0u, 1u, 2u}) {
    const std::vector<Eigen::Vector3f> few(points.begin(), points.begin() + count);
    const ProjectionMesh mesh = MeshByProjection(few, kApart_m);
    EXPECT_EQ(mesh.vertices, few);
    EXPECT_THAT(mesh.triangles, IsEmpty());
  }
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(MeshByProjection(points, kApart_m, {.stop = stop.get_token()}), Stopped);
}

}  // namespace
}  // namespace cwm::perception
