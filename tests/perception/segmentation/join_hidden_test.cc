// Two parts of a front 1 m away with a pole between them, 30 cm nearer to the sensor: the reasons
// to keep them apart although the pole hides everything between them. More cases are in
// join_test.cc.
#include "perception/segmentation/join_hidden.h"

#include <gtest/gtest.h>

#include "perception/cloud/tolerances.h"
#include "tests/perception/segmentation/hand_built_pieces.h"

namespace cwm::perception {
namespace {

const Vector2 kPartHeights_m(-0.6, -0.5), kLeftPart_m(-0.15, -0.04), kRightPart_m(0.04, 0.15);

void AddPole(PiecesByHand& seen) { seen.AddFront(0.7, {-0.03, 0.03}, {-0.5, -0.3}); }

DisjointSets JoinedBehindPole(const PiecesByHand& seen, DisjointSets objects) {
  JoinAcrossOccluders(seen.nodes(), seen.views(),
                      SightMap(seen.nodes(), PiecesByHand::kDirections_rad), objects);
  return objects;
}

DisjointSets JoinedBehindPole(const PiecesByHand& seen) {
  return JoinedBehindPole(seen, DisjointSets(seen.views().pieces.size()));
}

TEST(JoinBehindAPole, KeepsFrontsApartThatAreTurned) {
  for (const double turn_deg : {0.0, 10.0}) {
    PiecesByHand seen;
    const std::size_t left = seen.AddFront(1, kLeftPart_m, kPartHeights_m);
    const std::size_t right = seen.AddFront(1, kRightPart_m, kPartHeights_m, turn_deg * kDegree);
    AddPole(seen);
    DisjointSets joined = JoinedBehindPole(seen);
    EXPECT_EQ(joined.Root(left) == joined.Root(right), turn_deg == 0) << turn_deg;
  }
}

// Specks of 1.4 cm^2 are too small to be tested themselves, but belong to the whole that they were
// joined with.
TEST(JoinBehindAPole, KeepsTwoWholesApartAndGivesAPartToAWhole) {
  for (const int wholes : {1, 2}) {
    PiecesByHand seen;
    const std::size_t left = seen.AddFront(1, kLeftPart_m, kPartHeights_m);
    const std::size_t right = seen.AddFront(1, kRightPart_m, kPartHeights_m);
    AddPole(seen);
    const std::size_t of_left = seen.AddFront(1.1, {-0.2, -0.188}, {-0.6, -0.588});
    const std::size_t of_right = seen.AddFront(1.1, {0.188, 0.2}, {-0.6, -0.588});
    DisjointSets before(seen.views().pieces.size());
    before.Join(left, of_left);
    if (wholes == 2) before.Join(right, of_right);
    DisjointSets joined = JoinedBehindPole(seen, before);
    EXPECT_EQ(joined.Root(left) == joined.Root(right), wholes == 1) << wholes;
    EXPECT_EQ(joined.Root(right) == joined.Root(of_right), wholes == 2) << wholes;
  }
}

// A piece below 3.5 cm^2 does not determine a plane: a square of 1.6 cm has 2.6 cm^2.
TEST(JoinBehindAPole, JoinsNoPartThatIsTooSmallToFixAPlane) {
  for (const double side_m : {0.016, 0.04}) {
    PiecesByHand seen;
    const std::size_t left = seen.AddFront(1, {-0.04 - side_m, -0.04}, {-0.57, -0.57 + side_m});
    const std::size_t right = seen.AddFront(1, {0.04, 0.04 + side_m}, {-0.57, -0.57 + side_m});
    AddPole(seen);
    DisjointSets joined = JoinedBehindPole(seen);
    EXPECT_EQ(joined.Root(left) == joined.Root(right), side_m == 0.04) << side_m;
  }
}

TEST(JoinBehindAPole, JoinsNothingWhereThereIsNothingOrSupportsAlone) {
  PiecesByHand nothing;
  JoinedBehindPole(nothing);
  PiecesByHand seen;
  const std::size_t support = seen.AddEmpty(), other = seen.AddEmpty();
  const std::size_t left = seen.AddFront(1, kLeftPart_m, kPartHeights_m);
  DisjointSets joined = JoinedBehindPole(seen);
  EXPECT_EQ(joined.Root(support), support);
  EXPECT_EQ(joined.Root(other), other);
  EXPECT_EQ(joined.Root(left), left);
}

}  // namespace
}  // namespace cwm::perception
