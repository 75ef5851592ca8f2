#include "perception/handles/handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace cwm::perception {
namespace {

constexpr double kSpacing_m = 0.002;
constexpr double kRadius_m = 0.04;

// An upright cup at the origin.
std::vector<ShapePart> Cup() {
  return {{.X_OS = Pose::Identity(), .shape = Cylinder{.radius_m = kRadius_m, .length_m = 0.1}}};
}

// A straight bar of `length_m` along z with a square cross section of `width_m`. Its near side is
// `gap_m` from the cup's wall and its points are `kSpacing_m` apart, on the two faces that a sensor
// at (1, 1, 0) sees.
OrientedPoints Bar(double gap_m, double width_m, double length_m) {
  OrientedPoints points;
  points.viewpoint = Vector3(1, 1, 0);
  const double last_m = width_m - kSpacing_m / 2;
  for (double x = 0; x <= width_m; x += kSpacing_m) {
    for (double y = 0; y <= width_m; y += kSpacing_m) {
      if (x < last_m && y < last_m) continue;
      for (double z = 0; z <= length_m; z += kSpacing_m) {
        points.points.emplace_back(static_cast<float>(kRadius_m + gap_m + x),
                                   static_cast<float>(y - width_m / 2),
                                   static_cast<float>(z - length_m / 2));
        points.sigma_m.push_back(0.0015f);
      }
    }
  }
  return points;
}

std::vector<Handle> Find(const OrientedPoints& points, std::vector<std::int32_t>& parts,
                         const Ground& ground = {}) {
  ObjectModel model{.shapes = Cup(), .handles = {}, .part_of_point = {}, .notes = {}};
  model.part_of_point.assign(points.points.size(), kUnexplained);
  FindHandles(points, kSpacing_m, ground, model, kSerialWork);
  parts = model.part_of_point;
  return model.handles;
}

TEST(FindHandles, FindsAnElongatedClusterAtTheWall) {
  const OrientedPoints bar = Bar(0.01, 0.016, 0.06);
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

// Half a ring of 26 mm radius and 12 mm thickness that stands out from the wall: no longer than
// wide.
TEST(FindHandles, FindsTheEarOfAMug) {
  OrientedPoints ear;
  ear.viewpoint = Vector3(0, -1, 0);
  for (double turn_rad = -1.4; turn_rad <= 1.4; turn_rad += 0.05) {
    for (double across_rad = 0; across_rad <= std::numbers::pi; across_rad += 0.2) {
      const double away_m = 0.026 + 0.006 * std::cos(across_rad);
      ear.points.push_back(Eigen::Vector3d(kRadius_m + away_m * std::cos(turn_rad),
                                           -0.006 * std::sin(across_rad),
                                           away_m * std::sin(turn_rad))
                               .cast<float>());
    }
  }
  ear.sigma_m.assign(ear.points.size(), 0.0015f);
  std::vector<std::int32_t> parts;
  ASSERT_EQ(Find(ear, parts).size(), 1u);
}

TEST(FindHandles, RefusesWhatIsFarThickShortOrFew) {
  struct Case {
    const char* what;
    OrientedPoints points;
  };
  const Case cases[] = {{"begins 20 mm from the wall", Bar(0.02, 0.016, 0.06)},
                        {"40 mm thick", Bar(0.01, 0.04, 0.08)},
                        {"as long as wide", Bar(0.01, 0.02, 0.02)},
                        {"nearer to the wall than 15 mm all over", Bar(0.002, 0.01, 0.06)},
                        {"50 points", {}}};
  for (const auto& [what, given] : cases) {
    OrientedPoints points = given;
    if (points.points.empty()) {
      points = Bar(0.01, 0.016, 0.06);
      points.points.resize(50);
      points.sigma_m.resize(50);
    }
    std::vector<std::int32_t> parts;
    EXPECT_TRUE(Find(points, parts).empty()) << what;
    EXPECT_TRUE(std::all_of(parts.begin(), parts.end(), [](auto p) { return p == kUnexplained; }));
  }
}

TEST(FindHandles, TakesNothingThatLiesOnTheGround) {
  const OrientedPoints bar = Bar(0.01, 0.016, 0.06);  // from 3 cm below the origin to 3 cm above it
  std::vector<std::int32_t> parts;
  const Ground along{.known = true, .up = Vector3::UnitX(), .point = {kRadius_m + 0.022, 0, 0}};
  EXPECT_TRUE(Find(bar, parts, along).empty());
  const Ground below{.known = true, .up = Vector3::UnitZ(), .point = {0, 0, -0.03}};
  EXPECT_EQ(Find(bar, parts, below).size(), 1u);
}

TEST(FindHandles, TakesNoPatchThatContinuesTheWall) {
  // Above the end of the cup, where its wall would continue: 60 mm high, 15 mm wide and bent like
  // the wall.
  OrientedPoints patch;
  for (double z = 0.055; z <= 0.115; z += kSpacing_m / 2) {
    for (double angle_rad = -0.2; angle_rad <= 0.2; angle_rad += kSpacing_m / 2 / kRadius_m) {
      patch.points.push_back(
          Eigen::Vector3d(kRadius_m * std::cos(angle_rad), kRadius_m * std::sin(angle_rad), z)
              .cast<float>());
    }
  }
  patch.sigma_m.assign(patch.points.size(), 0.0015f);
  std::vector<std::int32_t> parts;
  EXPECT_TRUE(Find(patch, parts).empty());
}

// The solids left of a cup and `small`: all `points` belong to `small`, besides many points of the
// cup.
std::vector<ShapePart> Dropped(const OrientedPoints& points, const ShapePart& small,
                               std::vector<std::int32_t>& parts) {
  constexpr std::size_t kOfCup = 20000;
  std::vector<ShapePart> solids = Cup();
  solids.push_back(small);
  OrientedPoints all;
  all.points.assign(kOfCup, Eigen::Vector3f(kRadius_m, 0, 0));
  all.points.insert(all.points.end(), points.points.begin(), points.points.end());
  all.sigma_m.assign(all.points.size(), 0.0015f);
  parts.assign(all.points.size(), 1);
  std::fill_n(parts.begin(), kOfCup, 0);
  DropSolidsOfHandles(all, kSpacing_m, Ground(), solids, parts, kSerialWork);
  return solids;
}

TEST(DropSolidsOfHandles, FreesASmallCylinderOnTheSide) {
  const OrientedPoints bar = Bar(0.01, 0.016, 0.06);
  std::vector<std::int32_t> parts;
  const ShapePart ear{.X_OS = MakeTranslation(0.06, 0, 0),
                      .shape = Cylinder{.radius_m = 0.01, .length_m = 0.06}};
  EXPECT_EQ(Dropped(bar, ear, parts).size(), 1u);
  EXPECT_EQ(std::count(parts.begin(), parts.end(), kUnexplained),
            static_cast<std::ptrdiff_t>(bar.points.size()));
}

// A box that is fitted to a bow and to the wall beside it holds points of both.
TEST(DropSolidsOfHandles, GivesTheHostItsWallBack) {
  OrientedPoints bar = Bar(0.02, 0.016, 0.06);
  constexpr std::ptrdiff_t kOfWall = 40;
  bar.points.insert(bar.points.end(), kOfWall, Eigen::Vector3f(kRadius_m + 0.001f, 0, 0));
  std::vector<std::int32_t> parts;
  const ShapePart ear{.X_OS = MakeTranslation(0.06, 0, 0), .shape = Box{{0.04, 0.02, 0.06}}};
  EXPECT_EQ(Dropped(bar, ear, parts).size(), 1u);
  EXPECT_EQ(std::count(parts.end() - kOfWall, parts.end(), 0), kOfWall);
  EXPECT_EQ(std::count(parts.begin(), parts.end(), kUnexplained),
            static_cast<std::ptrdiff_t>(bar.points.size()) - kOfWall);
}

TEST(DropSolidsOfHandles, LeavesWhatStandsOnTheAxis) {
  OrientedPoints neck;  // of a bottle
  for (int i = 0; i < 200; ++i) {
    const float angle_rad = 0.1f * static_cast<float>(i);
    neck.points.emplace_back(0.012f * std::cos(angle_rad), 0.012f * std::sin(angle_rad),
                             0.05f + 0.0003f * static_cast<float>(i));
  }
  std::vector<std::int32_t> parts;
  const ShapePart part{.X_OS = MakeTranslation(0, 0, 0.08),
                       .shape = Cylinder{.radius_m = 0.012, .length_m = 0.06}};
  EXPECT_EQ(Dropped(neck, part, parts).size(), 2u);
  EXPECT_EQ(std::count(parts.begin(), parts.end(), 1), 200);
}

TEST(FindHandles, LeavesPointsOfShapesAlone) {
  const OrientedPoints bar = Bar(0.01, 0.016, 0.06);
  ObjectModel model{.shapes = Cup(), .handles = {}, .part_of_point = {}, .notes = {}};
  model.part_of_point.assign(bar.points.size(), 0);  // all explained by the cup
  FindHandles(bar, kSpacing_m, Ground(), model, kSerialWork);
  EXPECT_TRUE(model.handles.empty());
}

}  // namespace
}  // namespace cwm::perception
