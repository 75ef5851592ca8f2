// Level rectangles above each other and side by side, without noise.
#include "perception/segmentation/support_planes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "tests/perception/segmentation/drawn_image.h"

namespace cwm::perception {
namespace {

struct LevelSquare {
  double from_m, to_m;  // along x and along y
  bool Has(double x, double y) const { return x > from_m && x < to_m && y > from_m && y < to_m; }
};
constexpr LevelSquare kNoHole{0, 0}, kWholeTable{0, 0.6};

class LevelCloud {
 public:
  LevelCloud& AddLevel(double z_m, const LevelSquare& square, const LevelSquare& hole = kNoHole) {
    return AddRectangle(z_m, {square.from_m, square.to_m}, {square.from_m, square.to_m}, hole);
  }
  LevelCloud& AddRectangle(double z_m, const Vector2& x_m, const Vector2& y_m,
                           const LevelSquare& hole = kNoHole) {
    for (double x = x_m.x() + 0.5 * kStepOfLevels_m; x < x_m.y(); x += kStepOfLevels_m) {
      for (double y = y_m.x() + 0.5 * kStepOfLevels_m; y < y_m.y(); y += kStepOfLevels_m) {
        if (!hole.Has(x, y)) Put({x, y, z_m}, Vector3::UnitZ());
      }
    }
    return *this;
  }
  // Adds an upright rectangle at x = `x_m` that faces -x.
  LevelCloud& AddFront(double x_m, const Vector2& y_m, const Vector2& z_m) {
    for (double y = y_m.x() + 0.5 * kStepOfLevels_m; y < y_m.y(); y += kStepOfLevels_m) {
      for (double z = z_m.x() + 0.5 * kStepOfLevels_m; z < z_m.y(); z += kStepOfLevels_m) {
        Put({x_m, y, z}, -Vector3::UnitX());
      }
    }
    return *this;
  }
  // Reverses all normals.
  LevelCloud& TurnNormals() {
    for (Eigen::Vector3f& n : points_.normals) n = -n;
    return *this;
  }

  // Finds the supports when the sensor's position is unknown.
  std::vector<SupportPlane> Find() const {
    return FindSupportPlanes(MakeCoarseCloud(points_), Vector3::UnitZ(), nullptr, {});
  }

 private:
  static constexpr double kStepOfLevels_m = 0.005;

  void Put(const Vector3& place, const Vector3& normal) {
    points_.cloud_index.push_back(static_cast<std::uint32_t>(points_.size()));
    points_.points.push_back(place.cast<float>());
    points_.normals.push_back(normal.cast<float>());
    points_.sigma_m.push_back(0.0015f);
    points_.normal_sigma_rad.push_back(0.02f);
  }

  OrientedPoints points_;
};

TEST(FindSupportPlanes, FindsATableAndAShelfHighAboveItTheLargerFirst) {
  const std::vector<SupportPlane> found =
      LevelCloud().AddLevel(0.1, {0.1, 0.5}).TurnNormals().AddLevel(-0.5, kWholeTable).Find();
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found[0].plane.offset_m, -0.5, 1e-4);
  EXPECT_NEAR(found[1].plane.offset_m, 0.1, 1e-4);
  for (const SupportPlane& support : found) EXPECT_GT(support.plane.normal.z(), 0.999);
  // One cell of 15 mm more on each side.
  EXPECT_NEAR(found[0].area_m2, 0.36, 0.02);
  EXPECT_NEAR(found[1].area_m2, 0.16, 0.02);
}

// 20 or 30 cm above a table of 60 x 60 cm, which is not seen below a solid object.
TEST(FindSupportPlanes, LeavesOutTopsOfObjectsButNotBoardsThatOneSeesUnder) {
  constexpr LevelSquare kSmall{0.2, 0.38}, kBoard{0.15, 0.45}, kLarge{0.1, 0.5};
  EXPECT_EQ(LevelCloud().AddLevel(0, kWholeTable, kSmall).AddLevel(0.2, kSmall).Find().size(), 1u);
  EXPECT_EQ(LevelCloud().AddLevel(0, kWholeTable, kBoard).AddLevel(0.3, kBoard).Find().size(), 1u);
  EXPECT_EQ(LevelCloud().AddLevel(0, kWholeTable).AddLevel(0.3, kBoard).Find().size(), 2u);
  // The large box leaves too little of the table around it; its front shows that it is solid.
  LevelCloud solid;
  solid.AddLevel(0, kWholeTable, kLarge).AddLevel(0.2, kLarge);
  EXPECT_EQ(solid.Find().size(), 2u);
  const std::vector<SupportPlane> table = solid.AddFront(0.1, {0.1, 0.5}, {0, 0.2}).Find();
  ASSERT_EQ(table.size(), 1u);
  EXPECT_NEAR(table[0].plane.offset_m, 0, 1e-3);
}

// Patches of one height: gaps of up to 30 cm are closed if the sensor's position is unknown.
TEST(FindSupportPlanes, MakesOneSupportOfWhatIsOnlySplitByAGapThatMayBeAShadow) {
  for (const double gap_m : {0.2, 0.4}) {
    const std::vector<SupportPlane> found =
        LevelCloud()
            .AddRectangle(0, {0, 0.25}, {0, 0.6})
            .AddRectangle(0, {0.25 + gap_m, 0.5 + gap_m}, {0, 0.6})
            .Find();
    ASSERT_EQ(found.size(), gap_m < 0.3 ? 1u : 2u) << gap_m;
    EXPECT_NEAR(found[0].area_m2, gap_m < 0.3 ? 0.3 : 0.15, 0.03) << gap_m;
  }
}

TEST(FindSupportPlanes, FindsNothingInAWallOrInWhatIsSmallerThanAnObject) {
  EXPECT_TRUE(LevelCloud().AddFront(1, {0, 0.6}, {0, 0.6}).Find().empty());
  EXPECT_TRUE(LevelCloud().AddLevel(0, {0, 0.1}).Find().empty());
}

// A patch of 24 x 18 cm, in cells of 15 mm.
TEST(MakeSubsampledCoarseCloud, FillsTheSameCellsWithFewerOfThePoints) {
  const MeasuredPoints image =
      DrawnImage({.width = 157, .height = 118, .focal_px = 525}, [](int, int) { return 0.8f; });
  const CoarseCloud full = MakeCoarseCloud(image.oriented),
                    sketch = MakeSubsampledCoarseCloud(image);
  EXPECT_FLOAT_EQ(sketch.grid.edge_m(), 0.015f);
  EXPECT_FLOAT_EQ(full.grid.edge_m(), 0.015f);
  EXPECT_EQ(full.grid.size(), std::size_t{16 * 12});
  EXPECT_EQ(sketch.grid.size(), full.grid.size());
  std::size_t sketched = 0;
  for (std::size_t c = 0; c < sketch.grid.size(); ++c) {
    sketched += sketch.grid.PointsOf(c).size();
    EXPECT_GE(sketch.grid.PointsOf(c).size(), 4u) << c;
    EXPECT_NEAR(sketch.cells.points[c].z(), 0.8, 1e-5) << c;
  }
  EXPECT_LT(sketched, image.oriented.size() / 4);
}

}  // namespace
}  // namespace cwm::perception
