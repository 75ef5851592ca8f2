#include "perception/solids/free_space.h"

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
  EXPECT_GT(found.examined, 100u);
  EXPECT_EQ(found.rays, 0u);
}

TEST(FindContradiction, CountsRaysThatRunDeeperThanTheGateOnly) {
  // Points inside the block: below its top by a tenth less and by a tenth more than is allowed.
  const Contradiction shallow = FindContradiction(Block(0), SquareAt(-0.9 * kMaxDepth_m));
  EXPECT_GT(shallow.examined, 100u);
  EXPECT_EQ(shallow.rays, 0u);
  const Contradiction deep = FindContradiction(Block(0), SquareAt(-1.1 * kMaxDepth_m));
  EXPECT_GT(deep.examined, 100u);
  EXPECT_EQ(deep.rays, deep.examined);
}

TEST(FindContradiction, SeesRaysThatCrossTheSolidOnTheirWay) {
  const Contradiction found = FindContradiction(Block(0), SquareAt(-0.3));
  EXPECT_GT(found.examined, 100u);
  EXPECT_EQ(found.rays, found.examined);
}

// A plug of 14 mm in the mouth of a pot: no point inside it is 10 mm deep.
TEST(FindContradiction, SeesRaysThatCrossWhatIsThin) {
  Solid plug;
  plug.shape = Cylinder{.radius_m = 0.2, .length_m = 0.014};
  const Contradiction through = FindContradiction(plug, SquareAt(-0.1));
  EXPECT_GT(through.examined, 100u);
  EXPECT_EQ(through.rays, through.examined);
  // The plug's own surface, displaced inwards by noise.
  const Contradiction own = FindContradiction(plug, SquareAt(0.007 - 0.004));
  EXPECT_EQ(own.rays, 0u);
}

FreeRay Level(double height_m) {
  FreeRay ray;
  for (int k = 0; k < kSamplesPerRay; ++k) {
    ray.p[static_cast<std::size_t>(k)] = Vector3(-0.5 + 0.2 * k, 0, height_m);
  }
  return ray;
}

// None of the sample positions along the rays lies in the block.
TEST(DeepRayCount, CountsMeasuredRaysThatRunDeepBetweenTheirPlaces) {
  FreeRays free;
  free.weight = 7;
  free.rays = {Level(0.02), Level(-0.5 * kMaxDepth_m), Level(-1.5 * kMaxDepth_m), Level(-0.05)};
  Solid narrow = Block(0);
  narrow.shape = Box{.size_m = {0.1, 0.2, 0.1}};
  narrow.X_MS = MakeTranslation(0, 0, -0.05);
  EXPECT_EQ(DeepRayCount(narrow, free), 2 * free.weight);
  EXPECT_EQ(CrossingRayShare(narrow, free), 0.75);
}

TEST(FindContradiction, AllowsThreeSigmaWhereThatIsMore) {
  constexpr double kDepth_m = 2 * kMaxDepth_m;
  ModelPoints points = SquareAt(-kDepth_m);
  points.gate_m.assign(points.size(), 1.1 * kDepth_m);
  const Contradiction allowed = FindContradiction(Block(0), points);
  EXPECT_GT(allowed.examined, 100u);
  EXPECT_EQ(allowed.rays, 0u);
  points.gate_m.assign(points.size(), 0.9 * kDepth_m);
  const Contradiction deep = FindContradiction(Block(0), points);
  EXPECT_EQ(deep.rays, deep.examined);
}

}  // namespace
}  // namespace cwm::perception
