#include "clients/planner/path_shortening.h"

#include <gtest/gtest.h>

#include "tests/clients/planner/flat_world.h"

namespace cwm::planner {
namespace {

TEST(Shorten, MakesAFreeWayStraight) {
  const JointSpace space(Flat(), 1);
  FlatWorld world({});
  const auto path = Shorten(space, world, {{-1, 0}, {-0.5, 0.9}, {0.2, -0.9}, {1, 0}}, {});
  ASSERT_TRUE(path.ok());
  EXPECT_EQ(*path, (std::vector<Row>{{-1, 0}, {1, 0}}));
}

TEST(Shorten, KeepsTheEndsAndGoesAroundWhatIsThere) {
  constexpr double kRadius = 0.3;
  const JointSpace space(Flat(), 1);
  for (std::uint32_t seed = 1; seed <= 20; ++seed) {
    FlatWorld world({{0, 0, kRadius}});
    const std::vector<Row> given = {{-1, 0}, {-1, 1}, {0, 0.9}, {1, 1}, {1, 0}};
    const auto path = Shorten(space, world, given, {.seed = seed});
    ASSERT_TRUE(path.ok());
    EXPECT_EQ(path->front(), given.front());
    EXPECT_EQ(path->back(), given.back());
    EXPECT_GE(MinClearance(world, *path), -MaxDepthBetween(kFineStep, kRadius) - 1e-9);
    // The shortest path has two tangents and an arc: 2 * 0.954 + 0.3 * 2 * asin(0.3) = 2.09.
    EXPECT_GE(LengthOf(space, *path), 2.09);
    EXPECT_LT(LengthOf(space, *path), 0.75 * LengthOf(space, given)) << "seed " << seed;
  }
}

TEST(Shorten, LeavesAPathOfOneMotionAlone) {
  const JointSpace space(Flat(), 1);
  FlatWorld world({});
  const auto path = Shorten(space, world, {{-1, 0}, {1, 0}}, {});
  ASSERT_TRUE(path.ok());
  EXPECT_EQ(path->size(), 2u);
  EXPECT_EQ(world.counts().batches, 0);
}

}  // namespace
}  // namespace cwm::planner
