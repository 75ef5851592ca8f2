#include "clients/planner/joint_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "tests/clients/planner/flat_world.h"

namespace cwm::planner {
namespace {

TEST(JointTree, FindsTheNearestThatTheDistanceFinds) {
  const std::vector<Joint> joints = {
      {.name = "turn", .kind = Joint::Kind::kContinuous},
      {.name = "bend", .kind = Joint::Kind::kLimited, .lower = -2, .upper = 2}};
  const JointSpace space(joints, 1);
  std::mt19937_64 random(3);
  const auto row = [&] {
    std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi), bend(-2, 2);
    return Row{turn(random), bend(random)};
  };
  JointTree tree(space, row());
  for (int k = 0; k < 500; ++k) tree.Add(0, row());
  for (int k = 0; k < 500; ++k) {
    const Row target = row();
    double min_distance = 1e9;
    for (int i = 0; i < tree.size(); ++i) {
      min_distance = std::min(min_distance, space.Distance(tree.row(i), target));
    }
    // The tree stores floats, which limits the accuracy.
    EXPECT_NEAR(space.Distance(tree.row(tree.Nearest(target)), target), min_distance, 1e-5);
  }
}

TEST(JointTree, CutsOffANodeWithAllThatGrewFromIt) {
  const JointSpace space(Flat(), 1);
  JointTree tree(space, Row{0, 0});
  const int a = tree.Add(0, Row{0.5, 0});
  const int b = tree.Add(a, Row{0.9, 0});
  const int c = tree.Add(0, Row{-0.5, 0});
  EXPECT_THAT(tree.PathTo(b), ::testing::ElementsAre(0, a, b));
  EXPECT_EQ(tree.Nearest(Row{1, 0}), b);
  tree.RemoveSubtree(a);
  EXPECT_FALSE(tree.IsAlive(b));
  EXPECT_TRUE(tree.IsAlive(c));
  EXPECT_EQ(tree.Nearest(Row{1, 0}), 0);
  EXPECT_EQ(tree.Nearest(Row{-1, 0}), c);
}

}  // namespace
}  // namespace cwm::planner
