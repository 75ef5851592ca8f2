#include "perception/segmentation/sight_map.h"

#include <gtest/gtest.h>

#include "perception/segmentation/support_gaps.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr float kPitch_rad = 0.01f;
constexpr float kTolerance_m = 0.01f;

// A wall at x = 2, wider than the map's cells, seen from the origin; nothing beyond 45 degrees.
OrientedPoints Wall() {
  OrientedPoints points;
  for (int v = -190; v <= 190; ++v) {
    for (int u = -190; u <= 190; ++u) {
      points.points.emplace_back(2.0f, 0.01f * static_cast<float>(u),
                                 0.01f * static_cast<float>(v));
      points.sigma_m.push_back(0.002f);
    }
  }
  return points;
}

TEST(SightMap, TellsInFrontOnAndBehind) {
  const SightMap sight(Wall(), kPitch_rad);
  EXPECT_EQ(sight.VisibilityAt({1, 0.2f, 0.3f}, kTolerance_m), Visibility::kSeenThrough);
  EXPECT_EQ(sight.VisibilityAt({3, 0.2f, 0.3f}, kTolerance_m), Visibility::kHidden);
  // On the wall straight ahead, where a cell of directions spans no range.
  EXPECT_EQ(sight.VisibilityAt({2, 0, 0}, kTolerance_m), Visibility::kOnSurface);
}

TEST(SightMap, KnowsNothingWhereNothingCameBack) {
  const SightMap sight(Wall(), kPitch_rad);
  EXPECT_EQ(sight.VisibilityAt({-1, 0, 0}, kTolerance_m), Visibility::kNoReturn);
  EXPECT_EQ(sight.VisibilityAt({0.1f, 1, -1}, kTolerance_m), Visibility::kNoReturn);
}

// A board of 0.6 m square 1 m in front of the sensor, and behind it the hidden part of the wall if
// `is_seen`.
OrientedPoints WallBehindABoard(bool is_seen) {
  OrientedPoints points;
  const OrientedPoints wall = Wall();
  for (const Vector3f& p : wall.points) {
    const bool is_behind = std::abs(p.y()) < 0.6f && std::abs(p.z()) < 0.6f;
    if (is_seen || !is_behind) points.points.push_back(p);
    if (is_behind) points.points.push_back(p / 2);
  }
  points.sigma_m.assign(points.points.size(), 0.002f);
  return points;
}

TEST(SeenFromOnePlace, IsNotWhatLiesBehindAnother) {
  EXPECT_TRUE(IsSeenFromOnePlace(WallBehindABoard(false)));
  EXPECT_FALSE(IsSeenFromOnePlace(WallBehindABoard(true)));
}

// The top of a table 1 m below the sensor at the origin, seen at |y| > `half_gap_m`. In the gap,
// the rays end on the floor `drop_m` below it, on a nearer object, or nowhere.
struct GapScene {
  OrientedPoints points;
  std::vector<std::uint32_t> left, right;
};

enum class Between { kFloor, kObject, kNothing };

GapScene TableWithGap(float half_gap_m, float drop_m, Between between) {
  GapScene scene;
  for (int i = -60; i <= 60; ++i) {
    for (int j = 20; j <= 80; ++j) {
      const Vector3f place(0.01f * static_cast<float>(j), 0.01f * static_cast<float>(i), -1);
      const auto index = static_cast<std::uint32_t>(scene.points.size());
      if (std::abs(place.y()) > half_gap_m) {
        (place.y() < 0 ? scene.right : scene.left).push_back(index);
        scene.points.points.push_back(place);
      } else if (between == Between::kNothing) {
        continue;
      } else {
        // Along the ray to the place: beyond it or in front of it.
        scene.points.points.push_back(place * (between == Between::kFloor ? 1 + drop_m : 0.9f));
      }
      scene.points.sigma_m.push_back(0.0015f);
    }
  }
  return scene;
}

bool IsOneSupport(const GapScene& scene) {
  const SightMap sight(scene.points, 0.012f);
  const Plane plane{Vector3::UnitZ(), -1};
  return IsGapClosed(plane, scene.points, scene.left, scene.right, &sight);
}

TEST(IsGapClosed, NotWhereTheFloorIsSeenThroughIt) {
  EXPECT_FALSE(IsOneSupport(TableWithGap(0.05f, 0.5f, Between::kFloor)));
}

TEST(IsGapClosed, WhereSomethingNearerHidesIt) {
  EXPECT_TRUE(IsOneSupport(TableWithGap(0.05f, 0, Between::kObject)));
}

TEST(IsGapClosed, WhereNothingReturned) {
  EXPECT_TRUE(IsOneSupport(TableWithGap(0.05f, 0, Between::kNothing)));
}

TEST(IsGapClosed, WhereWhatIsSeenIsShallowerThanAPlate) {
  EXPECT_TRUE(IsOneSupport(TableWithGap(0.05f, 0.015f, Between::kFloor)));
  EXPECT_FALSE(IsOneSupport(TableWithGap(0.05f, 0.03f, Between::kFloor)));
}

TEST(IsGapClosed, ByItsWidthAloneWhenTheSensorIsUnknown) {
  const Plane plane{Vector3::UnitZ(), -1};
  const GapScene narrow = TableWithGap(0.9f * static_cast<float>(kClosing_m), 0, Between::kNothing);
  EXPECT_TRUE(IsGapClosed(plane, narrow.points, narrow.left, narrow.right, nullptr));
  const GapScene wide = TableWithGap(1.1f * static_cast<float>(kClosing_m), 0, Between::kNothing);
  EXPECT_FALSE(IsGapClosed(plane, wide.points, wide.left, wide.right, nullptr));
}

}  // namespace
}  // namespace cwm::perception
