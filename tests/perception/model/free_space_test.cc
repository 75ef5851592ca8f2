#include "perception/model/free_space.h"

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

// Points of a square of 10 cm around the z axis at this height, seen from 1 m above the origin.
ModelPoints SquareAt(double z_m) {
  ModelPoints points;
  points.viewpoint = Vector3(0, 0, 1);
  for (int i = 0; i < 20; ++i) {
    for (int j = 0; j < 20; ++j) {
      points.p.emplace_back(0.005 * i - 0.0475, 0.005 * j - 0.0475, z_m);
      points.gate_m.push_back(0.004);
    }
  }
  return points;
}

Solid Block(double top_m) {
  Solid solid;
  solid.shape = Box{.size_m = {0.2, 0.2, 0.1}};
  solid.X_MS = MakeTranslation(0, 0, top_m - 0.05);
  return solid;
}

TEST(FindContradiction, SaysNothingAgainstASolidWhoseTopWasSeen) {
  const Contradiction found = FindContradiction(Block(0), SquareAt(0));
  EXPECT_GT(found.looked, 100u);
  EXPECT_EQ(found.rays, 0u);
}

TEST(FindContradiction, CountsRaysThatRunDeeperThanTheGateOnly) {
  // Points inside of the block: below its top by a tenth more and less than what is allowed.
  EXPECT_EQ(FindContradiction(Block(0), SquareAt(-0.9 * kMostDepth_m)).rays, 0u);
  const Contradiction deep = FindContradiction(Block(0), SquareAt(-1.1 * kMostDepth_m));
  EXPECT_EQ(deep.rays, deep.looked);
}

TEST(FindContradiction, SeesRaysThatCrossTheSolidOnTheirWay) {
  const Contradiction found = FindContradiction(Block(0), SquareAt(-0.3));
  EXPECT_GT(found.looked, 100u);
  EXPECT_EQ(found.rays, found.looked);
}

TEST(FindContradiction, AllowsThreeSigmaWhereThatIsMore) {
  ModelPoints points = SquareAt(-0.02);
  points.gate_m.assign(points.p.size(), 0.022);
  EXPECT_EQ(FindContradiction(Block(0), points).rays, 0u);
}

}  // namespace
}  // namespace cwm::perception
