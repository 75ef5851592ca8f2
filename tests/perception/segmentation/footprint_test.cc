#include "perception/segmentation/footprint.h"

#include <gtest/gtest.h>

#include <numeric>
#include <vector>

namespace cwm::perception {
namespace {

constexpr double kCell_m = 0.015;

// The footprint of cells on the plane z = 1: a square of 20 x 20 without one quarter and without a
// hole.
class FootprintOfAnL : public ::testing::Test {
 protected:
  FootprintOfAnL() {
    for (int x = 0; x < 20; ++x) {
      for (int y = 0; y < 20; ++y) {
        const bool is_notch = x >= 10 && y >= 10;
        const bool is_hole = x >= 3 && x < 7 && y >= 3 && y < 7;
        if (is_notch || is_hole) continue;
        points_.points.push_back(Place(x, y, 1).cast<float>());
      }
    }
    members_.resize(points_.points.size());
    std::iota(members_.begin(), members_.end(), 0u);
  }
  // The middle of a cell.
  static Vector3 Place(int x, int y, double z_m) {
    return {(x + 0.5) * kCell_m, (y + 0.5) * kCell_m, z_m};
  }
  Footprint Made() const {
    return {{.normal = Vector3::UnitZ(), .offset_m = 1}, points_, members_, kCell_m};
  }
  bool Surrounds(int x, int y, double z_m) const { return Made().Surrounds(Place(x, y, z_m)); }
  bool Covers(int x, int y, double z_m) const { return Made().Covers(Place(x, y, z_m)); }

  OrientedPoints points_;
  std::vector<std::uint32_t> members_;
};

TEST_F(FootprintOfAnL, SurroundsWhatLiesOverAndUnderIt) {
  EXPECT_TRUE(Surrounds(5, 15, 1.3));
  EXPECT_TRUE(Surrounds(15, 5, 0.2));
  EXPECT_TRUE(Surrounds(5, 5, 1.1)) << "over its hole, where something may stand";
}

TEST_F(FootprintOfAnL, SurroundsNothingBesideItOrInItsNotch) {
  EXPECT_FALSE(Surrounds(15, 15, 1.3));
  EXPECT_FALSE(Surrounds(25, 5, 1));
  EXPECT_FALSE(Surrounds(0, 5, 1.1)) << "at its border";
}

TEST_F(FootprintOfAnL, CoversWhatLiesUnderItsMiddleButNotUnderItsHole) {
  EXPECT_TRUE(Covers(4, 14, 0.2));
  EXPECT_TRUE(Covers(14, 4, 0.2));
  EXPECT_FALSE(Covers(5, 5, 0.2)) << "under its hole";
  EXPECT_FALSE(Covers(0, 5, 0.2)) << "at its border";
  EXPECT_FALSE(Covers(15, 15, 0.2)) << "in its notch";
}

}  // namespace
}  // namespace cwm::perception
