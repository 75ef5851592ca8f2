#include "perception/model/handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace cwm::perception {
namespace {

constexpr double kSpacing_m = 0.002;
constexpr double kRadius_m = 0.04;

// A cup at the origin, upright.
std::vector<ShapePart> Cup() {
  return {{.X_OS = Pose::Identity(), .shape = Cylinder{.radius_m = kRadius_m, .length_m = 0.1}}};
}

// A straight bar of `length_m` along z and a square of `width_m` across, its near side `gap_m` from
// the cup's wall, its points `kSpacing_m` apart.
OrientedPoints Bar(double gap_m, double width_m, double length_m) {
  OrientedPoints points;
  for (double x = 0; x <= width_m; x += kSpacing_m) {
    for (double y = 0; y <= width_m; y += kSpacing_m) {
      for (double z = 0; z <= length_m; z += kSpacing_m) {
        points.points.emplace_back(static_cast<float>(kRadius_m + gap_m + x),
                                   static_cast<float>(y - width_m / 2),
                                   static_cast<float>(z - length_m / 2));
      }
    }
  }
  return points;
}

std::vector<Handle> Find(const OrientedPoints& points, std::vector<std::int32_t>& parts) {
  parts.assign(points.points.size(), kUnexplained);
  return FindHandles(points, Cup(), kSpacing_m, parts, kUnbounded);
}

TEST(FindHandles, FindsAnElongatedClusterAtTheWall) {
  const OrientedPoints bar = Bar(0.01, 0.02, 0.06);
  std::vector<std::int32_t> parts;
  const std::vector<Handle> handles = Find(bar, parts);
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_EQ(handles[0].shape_index, 0);
  EXPECT_EQ(handles[0].point_count, static_cast<int>(bar.points.size()));
  EXPECT_GT(handles[0].axis_O.z(), 0.99);
  EXPECT_NEAR(handles[0].bounds.shape.size_m.x(), 0.06, kSpacing_m);
  // Part 0 is the cup, part 1 its handle.
  EXPECT_TRUE(std::all_of(parts.begin(), parts.end(), [](std::int32_t p) { return p == 1; }));
}

TEST(FindHandles, RefusesWhatIsFarThickShortOrFew) {
  struct Case {
    const char* what;
    OrientedPoints points;
  };
  const Case cases[] = {{"begins 20 mm from the wall", Bar(0.02, 0.02, 0.06)},
                        {"40 mm thick", Bar(0.01, 0.04, 0.08)},
                        {"as long as wide", Bar(0.01, 0.02, 0.02)},
                        {"nearer to the wall than 15 mm all over", Bar(0.002, 0.01, 0.06)},
                        {"50 points", {}}};
  for (const auto& [what, given] : cases) {
    OrientedPoints points = given;
    if (points.points.empty()) {
      points = Bar(0.01, 0.02, 0.06);
      points.points.resize(50);
    }
    std::vector<std::int32_t> parts;
    EXPECT_TRUE(Find(points, parts).empty()) << what;
    EXPECT_TRUE(std::all_of(parts.begin(), parts.end(), [](auto p) { return p == kUnexplained; }));
  }
}

TEST(FindHandles, LeavesPointsOfShapesAlone) {
  const OrientedPoints bar = Bar(0.01, 0.02, 0.06);
  std::vector<std::int32_t> parts(bar.points.size(), 0);  // all explained by the cup
  EXPECT_TRUE(FindHandles(bar, Cup(), kSpacing_m, parts, kUnbounded).empty());
}

}  // namespace
}  // namespace cwm::perception
