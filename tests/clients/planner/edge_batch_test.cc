#include "clients/planner/edge_batch.h"

#include <gtest/gtest.h>

#include "tests/clients/planner/flat_world.h"

namespace cwm::planner {
namespace {

TEST(EdgeBatch, AsksAboutAllMotionsAtOnceAndTellsHowFarEachIsFree) {
  const JointSpace space(Flat(), 1);
  FlatWorld world({{0, 0, 0.25}});
  EdgeBatch batch(space, world);
  const std::size_t beside = batch.Add({{-1, 0.5}}, {{1, 0.5}}, 0.01);
  const std::size_t through = batch.Add({{-1, 0}}, {{1, 0}}, 0.01);
  const std::size_t out = batch.Add({{0.2, 0}}, {{1, 0}}, 0.01);  // its start is not checked
  const std::size_t state = batch.Add({{0, 0}});
  ASSERT_TRUE(batch.CheckAll().ok());
  EXPECT_EQ(world.counts().batches, 1);
  EXPECT_EQ(world.counts().states, 200 + 200 + 80 + 1);
  EXPECT_TRUE(batch.IsFree(beside));
  EXPECT_FALSE(batch.IsFree(through));
  // The motion goes from x = -1 to 1, and the disc begins at -0.25, within a step.
  EXPECT_NEAR(batch.FreeFraction(through), 0.375, 0.005);
  EXPECT_EQ(batch.FreeFraction(out), 0);
  EXPECT_FALSE(batch.IsFree(state));
}

TEST(EdgeBatch, AsksTheEndOfTheShortestMotionAndNothingOfNone) {
  const JointSpace space(Flat(), 1);
  FlatWorld world({{0, 0, 0.25}});
  EdgeBatch batch(space, world);
  ASSERT_TRUE(batch.CheckAll().ok());
  EXPECT_EQ(world.counts().batches, 0);
  batch.Add({{0, 0.5}}, {{0, 0.5}}, 0.01);
  ASSERT_TRUE(batch.CheckAll().ok());
  EXPECT_TRUE(batch.IsFree(0));
  EXPECT_EQ(world.counts().states, 1);
  batch.Add({{-1, 0.5}}, {{-0.995, 0.5}}, 0.01, 2);
  batch.Add({{-1, 0.5}}, {{0, 0.5}}, 0.01, 2);
  ASSERT_TRUE(batch.CheckAll().ok());
  EXPECT_EQ(world.counts().states, 1 + 2 + 200);
}

}  // namespace
}  // namespace cwm::planner
