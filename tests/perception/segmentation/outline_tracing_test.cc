// Outlines of small sets of cells, whose corners and areas are counted by hand.
#include "perception/segmentation/outline_tracing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace cwm::perception {
namespace {

struct CellRange {
  int first, last;  // `last` is not included
};

class DrawnCells {
 public:
  explicit DrawnCells(int side) : mask_(CellMask::Empty(side, side)) {}

  DrawnCells& Fill(const CellRange& columns, const CellRange& rows) {
    return Set(columns, rows, true);
  }
  DrawnCells& Clear(const CellRange& columns, const CellRange& rows) {
    return Set(columns, rows, false);
  }
  Outline Trace() const { return TraceOutline(mask_); }

 private:
  DrawnCells& Set(const CellRange& columns, const CellRange& rows, bool on) {
    for (int y = rows.first; y < rows.last; ++y) {
      for (int x = columns.first; x < columns.last; ++x) mask_.on[mask_.Index(x, y)] = on;
    }
    return *this;
  }

  CellMask mask_;
};

std::vector<std::pair<double, double>> SortedCorners(const Polygon& polygon) {
  std::vector<std::pair<double, double>> corners;
  for (const Vector2& p : polygon) corners.emplace_back(p.x(), p.y());
  std::sort(corners.begin(), corners.end());
  return corners;
}

// A square of three cells: its outline runs midway to the neighbouring cells, with the corners cut
// off.
TEST(OutlineTracing, RunsMidwayBetweenCellsAndRoundHolesTheOtherWay) {
  const Outline outline = DrawnCells(3).Fill({0, 3}, {0, 3}).Clear({1, 2}, {1, 2}).Trace();
  EXPECT_EQ(
      SortedCorners(outline.border),
      (std::vector<std::pair<double, double>>{
          {-0.5, 0}, {-0.5, 2}, {0, -0.5}, {0, 2.5}, {2, -0.5}, {2, 2.5}, {2.5, 0}, {2.5, 2}}));
  EXPECT_DOUBLE_EQ(SignedArea_m2(outline.border), 9 - 4 * 0.125);
  ASSERT_EQ(outline.holes.size(), 1u);
  EXPECT_EQ(SortedCorners(outline.holes[0]),
            (std::vector<std::pair<double, double>>{{0.5, 1}, {1, 0.5}, {1, 1.5}, {1.5, 1}}));
  EXPECT_DOUBLE_EQ(SignedArea_m2(outline.holes[0]), -0.5);
  EXPECT_EQ(outline.corner_count(), 12u);
}

// A ring without one corner: its ends touch in a corner only, where its inside is open to the
// outside. The area by blocks of four cells, row by row: 1.25 + 2.75 + 1.75 + 0.75.
TEST(OutlineTracing, PartsWhatTouchesInACornerAlone) {
  const Outline outline =
      DrawnCells(3).Fill({0, 3}, {0, 3}).Clear({1, 2}, {1, 2}).Clear({2, 3}, {2, 3}).Trace();
  EXPECT_TRUE(outline.holes.empty());
  EXPECT_TRUE(IsSimple(outline.border));
  EXPECT_DOUBLE_EQ(SignedArea_m2(outline.border), 6.5);
}

// A square of 20 cells. Four corners of its octagon lie less than half a cell from the lines
// between the others; a hole of one cell is thinner than the tolerance.
TEST(OutlineTracing, SimplifiesASquareToFourCornersAndDropsTheHolesThatNeedTheMost) {
  const auto square = [] { return DrawnCells(20).Fill({0, 20}, {0, 20}); };
  const Outline pierced = square().Clear({10, 11}, {10, 11}).Trace();
  const Outline simpler = Simplified(pierced, {.tolerance = 1});
  EXPECT_EQ(simpler.border.size(), 4u);
  EXPECT_TRUE(simpler.holes.empty());
  EXPECT_GT(SignedArea_m2(simpler.border), 375);

  const Outline two = square().Clear({2, 10}, {2, 10}).Clear({13, 17}, {13, 17}).Trace();
  ASSERT_EQ(two.holes.size(), 2u);
  EXPECT_EQ(Simplified(two, {.tolerance = 1}).corner_count(), 12u);
  const Outline fewer = Simplified(two, {.tolerance = 1, .max_corners = 8});
  EXPECT_EQ(fewer.border.size(), 4u);
  ASSERT_EQ(fewer.holes.size(), 1u);
  EXPECT_TRUE(Contains(fewer.holes[0], {5.5, 5.5})) << "the larger one";
  EXPECT_LT(SignedArea_m2(fewer.holes[0]), 0);
}

// An L of 40 cells has six corners, none nearer than 8 cells to a line between the others. With one
// corner less its concavity is filled.
TEST(OutlineTracing, GivesUpConcavitiesAtLastAndLeavesNothingAsItIs) {
  const Outline ell = DrawnCells(40).Fill({0, 40}, {0, 40}).Clear({20, 40}, {20, 40}).Trace();
  const Outline concave = Simplified(ell, {.tolerance = 1, .max_corners = 6});
  EXPECT_EQ(concave.border.size(), 6u);
  EXPECT_FALSE(Contains(concave.border, {24, 24}));
  const Outline convex = Simplified(ell, {.tolerance = 1, .max_corners = 5});
  EXPECT_EQ(convex.border.size(), 5u);
  EXPECT_TRUE(Contains(convex.border, {24, 24}));
  EXPECT_FALSE(Contains(convex.border, {36, 36}));
  EXPECT_GT(SignedArea_m2(convex.border), 0);
  EXPECT_EQ(Simplified(DrawnCells(2).Trace(), {.tolerance = 1}).corner_count(), 0u);
}

}  // namespace
}  // namespace cwm::perception
