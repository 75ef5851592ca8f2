#include "perception/segmentation/cell_mask.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "perception/segmentation/outline_tracing.h"

namespace cwm::perception {
namespace {

// The mask of rows of '#' and '.'; the first row is row 0.
CellMask MaskOf(const std::vector<std::string>& rows) {
  CellMask mask =
      CellMask::Empty(static_cast<int>(rows.front().size()), static_cast<int>(rows.size()));
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      mask.on[mask.Index(x, y)] =
          rows[static_cast<std::size_t>(y)][static_cast<std::size_t>(x)] == '#';
    }
  }
  return mask;
}

double Area(const Outline& outline) {
  double area = SignedArea_m2(outline.border);
  for (const Polygon& hole : outline.holes) area += SignedArea_m2(hole);
  return area;
}

TEST(CellMask, OpeningDropsWhatIsThinnerThanTheSquareAndKeepsTheRest) {
  const CellMask mask = MaskOf({"......", "####..", "####..", "######", "......"});
  EXPECT_EQ(Opened(mask, 1).on, MaskOf({"......", "####..", "####..", "####..", "......"}).on);
}

TEST(CellMask, ClosingFillsGapsOfTwiceItsReachAndNoWiderOnes) {
  EXPECT_EQ(Closed(MaskOf({"##..##", "##..##"}), 1).on, MaskOf({"######", "######"}).on);
  EXPECT_EQ(Closed(MaskOf({"##...##", "##...##"}), 1).on, MaskOf({"##...##", "##...##"}).on);
}

TEST(CellMask, ClosingAddsNothingBeyondTheSet) {
  const CellMask mask = MaskOf({"###...", "###...", "###...", "......"});
  EXPECT_EQ(Closed(mask, 2).on, mask.on);
}

TEST(CellMask, CellsThatMeetInACornerAreTwoComponents) {
  const Components parts = ComponentsOf(MaskOf({"#..", ".##"}));
  EXPECT_EQ(parts.count, 2);
  EXPECT_EQ(parts.of_cell, (std::vector<std::int32_t>{0, -1, -1, -1, 1, 1}));
}

TEST(TraceOutline, OfASingleCellIsTheDiamondRoundItsMiddle) {
  const Outline outline = TraceOutline(MaskOf({"#"}));
  ASSERT_EQ(outline.border.size(), 4u);
  EXPECT_DOUBLE_EQ(SignedArea_m2(outline.border), 0.5);
  EXPECT_TRUE(outline.holes.empty());
}

TEST(TraceOutline, OfARingHasItsHole) {
  const Outline outline = TraceOutline(MaskOf({"#####", "#####", "##.##", "#####", "#####"}));
  ASSERT_EQ(outline.holes.size(), 1u);
  EXPECT_TRUE(IsSimpleRegion(outline.border, outline.holes));
  EXPECT_TRUE(Contains(outline.holes[0], {2, 2}));
  // The outline runs midway between cells: 25 cells less an eighth at each corner and less the
  // hole's diamond.
  EXPECT_DOUBLE_EQ(Area(outline), 25 - 4 * 0.125 - 0.5);
}

TEST(TraceOutline, IsSimpleWhereHolesMeetInACorner) {
  const Outline outline = TraceOutline(MaskOf({"#####", "#.###", "##.##", "#####"}));
  EXPECT_TRUE(IsSimpleRegion(outline.border, outline.holes));
}

TEST(TraceOutline, OfNothingIsEmpty) { EXPECT_TRUE(TraceOutline(MaskOf({".."})).border.empty()); }

CellMask DiscWithHole(int radius) {
  CellMask mask = CellMask::Empty(2 * radius + 1, 2 * radius + 1);
  for (int y = -radius; y <= radius; ++y) {
    for (int x = -radius; x <= radius; ++x) {
      const int squared = x * x + y * y;
      mask.on[mask.Index(x + radius, y + radius)] =
          squared <= radius * radius && 9 * squared >= radius * radius;
    }
  }
  return mask;
}

TEST(Simplified, StaysWithinItsToleranceAndSimple) {
  const int radius = 60;
  const Outline full = TraceOutline(DiscWithHole(radius));
  const Outline simpler = Simplified(full, {.tolerance = 1, .max_corners = 64});
  EXPECT_LT(simpler.corner_count(), full.corner_count());
  EXPECT_LE(simpler.corner_count(), 64u);
  EXPECT_TRUE(IsSimpleRegion(simpler.border, simpler.holes));
  ASSERT_EQ(simpler.holes.size(), 1u);
  for (const Vector2& p : full.border) {
    EXPECT_LE((NearestOnBorder(simpler.border, p) - p).norm(), 1 + 1e-12);
  }
}

TEST(Simplified, KeepsTheLimitOfCornersWhateverItCosts) {
  const Outline full = TraceOutline(DiscWithHole(60));
  const Outline simpler = Simplified(full, {.tolerance = 0.01, .max_corners = 12});
  EXPECT_LE(simpler.corner_count(), 12u);
  EXPECT_GE(simpler.border.size(), 3u);
  EXPECT_TRUE(IsSimpleRegion(simpler.border, simpler.holes));
}

TEST(Simplified, LeavesAStaircaseOfOneCellAStraightLine) {
  const Outline stairs = TraceOutline(MaskOf({"########", "######..", "####....", "##......"}));
  EXPECT_LE(Simplified(stairs, {.tolerance = 1, .max_corners = 64}).border.size(), 5u);
}

}  // namespace
}  // namespace cwm::perception
