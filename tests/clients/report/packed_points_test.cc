#include "clients/report/packed_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

namespace cwm::report {
namespace {

using formats::CloudFile;
using Point = std::array<float, 3>;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

CloudFile CloudOf(const std::vector<Point>& points) {
  CloudFile cloud{.fields = {{.name = "x"}, {.name = "y"}, {.name = "z"}},
                  .width = static_cast<std::int64_t>(points.size())};
  cloud.point_step = formats::AssignOffsets(cloud.fields);
  cloud.bytes.assign(reinterpret_cast<const char*>(points.data()), points.size() * sizeof(Point));
  return cloud;
}

std::array<double, 3> PointAt(const PackedPoints& packed, std::size_t i) {
  std::array<double, 3> p;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t at = 2 * (3 * i + k);
    const int step = static_cast<unsigned char>(packed.grid[at]) +
                     256 * static_cast<unsigned char>(packed.grid[at + 1]);
    p[k] = packed.origin_m[k] + packed.step_m * step;
  }
  return p;
}

TEST(PackedPoints, KeepEveryMeasuredPointToHalfAStepInTheOrderOfLabels) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> metres(-2, 3);
  std::vector<Point> points(500);
  std::vector<std::uint32_t> labels(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {metres(random), metres(random), metres(random)};
    labels[i] = i % 3 == 0 ? 20 : 1;
  }
  const PackedPoints packed = PackPoints({CloudOf(points), labels});
  EXPECT_EQ(packed.measured, 500);
  EXPECT_EQ(packed.every, 1);
  EXPECT_EQ(packed.runs, (std::vector<PointRun>{{1, 333}, {20, 167}}));
  EXPECT_LE(packed.step_m, 1e-4);  // 5 m in 65 535 steps needs less
  ASSERT_EQ(packed.grid.size(), points.size() * 6);
  std::size_t at = 0;
  for (const std::uint32_t label : {1U, 20U}) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (labels[i] != label) continue;
      const auto p = PointAt(packed, at++);
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_NEAR(p[k], points[i][k], 0.5 * packed.step_m + 1e-9) << "point " << i;
      }
    }
  }
}

TEST(PackedPoints, LeaveOutPointsWithAnyCoordinateThatIsNoNumber) {
  const float infinity = std::numeric_limits<float>::infinity();
  const std::vector<Point> points = {{0, 0, 1},    {kNan, 0, 1},     {0, kNan, 1},
                                     {0, 0, kNan}, {0, 0, infinity}, {1, 1, 1}};
  const PackedPoints packed = PackPoints({CloudOf(points), {0, 0, 0, 0, 0, 0}});
  EXPECT_EQ(packed.measured, 2);
  EXPECT_EQ(packed.runs, (std::vector<PointRun>{{0, 2}}));
}

TEST(PackedPoints, WidenTheStepForWideScenesAlone) {
  const PackedPoints narrow = PackPoints({CloudOf({{0, 0, 1}, {1, 0, 1}}), {0, 0}});
  EXPECT_DOUBLE_EQ(narrow.step_m, 1e-4);
  const PackedPoints wide = PackPoints({CloudOf({{0, 0, 1}, {100, 0, 1}}), {0, 0}});
  EXPECT_DOUBLE_EQ(wide.step_m, 100.0 / 65535);
  EXPECT_NEAR(PointAt(wide, 1)[0], 100, 1e-9);
}

TEST(PackedPoints, AreThinnedLabelByLabelSoThatNoneVanishes) {
  const std::vector<Point> points(10, Point{0, 0, 1});
  std::vector<std::uint32_t> labels(10, 1);
  labels[4] = 20;
  const PackedPoints packed = PackPoints({CloudOf(points), labels}, /*max_points=*/4);
  EXPECT_EQ(packed.measured, 10);
  EXPECT_EQ(packed.every, 3);
  EXPECT_EQ(packed.runs, (std::vector<PointRun>{{1, 3}, {20, 1}}));
}

TEST(PackedPoints, OfNothingMeasuredAreNone) {
  const PackedPoints packed = PackPoints({CloudOf({{kNan, kNan, kNan}}), {0}});
  EXPECT_EQ(packed.measured, 0);
  EXPECT_TRUE(packed.runs.empty());
  EXPECT_EQ(packed.grid, "");
}

}  // namespace
}  // namespace cwm::report
