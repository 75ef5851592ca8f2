// Walls around one upright axis, 1 m in front of the sensor: the pieces that join with a vessel's
// inside.
#include "perception/segmentation/join_vessels.h"

#include <gtest/gtest.h>

#include "perception/cloud/tolerances.h"
#include "tests/perception/segmentation/hand_built_pieces.h"

namespace cwm::perception {
namespace {

// The visible arcs of walls: outsides in front of the axis, insides behind it.
const Vector2 kBefore_rad(-80 * kDegree, 80 * kDegree), kBehind_rad(110 * kDegree, 250 * kDegree);
constexpr double kInside_m = 0.037, kOutside_m = 0.04;  // radii

DisjointSets JoinedVessels(const PiecesByHand& seen) {
  DisjointSets objects(seen.views().pieces.size());
  JoinVessels(seen.nodes(), seen.views(), objects);
  return objects;
}

// A bowl that is seen from above shows only its inside.
TEST(VesselInsides, TakeTheFloorWithinThemAndNothingBeside) {
  PiecesByHand seen;
  const std::size_t support = seen.AddEmpty();
  const std::size_t inside = seen.AddWall(kInside_m, kBehind_rad, {-0.58, -0.5}, -1);
  const std::size_t floor = seen.AddLevel(-0.59, {0.98, 1.02}, {-0.02, 0.02});
  const std::size_t beside = seen.AddLevel(-0.59, {0.98, 1.02}, {0.06, 0.1});
  DisjointSets joined = JoinedVessels(seen);
  EXPECT_EQ(joined.Root(floor), joined.Root(inside));
  EXPECT_EQ(joined.Root(beside), beside);
  EXPECT_EQ(joined.Root(support), support);
}

// Pieces of 6.4 or 16 cm^2 in front of the axis, upright and facing the sensor.
TEST(VesselInsides, TakeSmallScrapsAndLeaveWhatMayBeAnObject) {
  for (const double width_m : {0.016, 0.04}) {
    PiecesByHand seen;
    const std::size_t inside = seen.AddWall(kInside_m, kBehind_rad, {-0.58, -0.5}, -1);
    const std::size_t scrap = seen.AddFront(0.99, {-0.5 * width_m, 0.5 * width_m}, {-0.57, -0.53});
    DisjointSets joined = JoinedVessels(seen);
    EXPECT_EQ(joined.Root(scrap) == joined.Root(inside), width_m < 0.02) << width_m;
  }
}

TEST(VesselInsides, JoinOutsidesWhoseRimsAreAtTheirHeight) {
  for (const double drop_m : {0.01, 0.035}) {  // the heights of one rim differ by up to 2 cm
    PiecesByHand seen;
    const std::size_t outside = seen.AddWall(kOutside_m, kBefore_rad, {-0.6, -0.5}, 1);
    const std::size_t inside = seen.AddWall(kInside_m, kBehind_rad, {-0.58, -0.5 - drop_m}, -1);
    DisjointSets joined = JoinedVessels(seen);
    EXPECT_EQ(joined.Root(outside) == joined.Root(inside), drop_m < 0.02) << drop_m;
  }
}

// Vessels have a radius of up to 30 cm.
TEST(VesselInsides, JoinNothingOfWhatIsWiderThanVesselsAre) {
  for (const double radius_m : {0.25, 0.35}) {
    PiecesByHand seen;
    const std::size_t outside = seen.AddWall(radius_m, kBefore_rad, {-0.6, -0.5}, 1);
    const std::size_t inside = seen.AddWall(radius_m - 0.003, kBehind_rad, {-0.58, -0.5}, -1);
    DisjointSets joined = JoinedVessels(seen);
    EXPECT_EQ(joined.Root(outside) == joined.Root(inside), radius_m < 0.3) << radius_m;
  }
}

}  // namespace
}  // namespace cwm::perception
