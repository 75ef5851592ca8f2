#include "perception/refinement/split/split_stacked_rounds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "perception/hypotheses/invariants.h"
#include "tests/perception/refinement/hand_built.h"

namespace cwm::perception {
namespace {

using ::testing::Eq;
using ::testing::IsEmpty;
using ::testing::Optional;
using ::testing::SizeIs;

// A can on a wider one.
TEST(SplitStackedRounds, MakesTwoOfCansOnOneAxis) {
  HandBuilt scene;
  const Placed<> low = Standing(Cylinder{0.05, 0.06}, 0, 0);
  const Placed<> high = Standing(Cylinder{0.035, 0.09}, 0, 0, 0.06);
  scene.Add({low, high});
  const RefinedScene refined = RunAlone(scene.StateWith({{low, high}}), "split.stacked_rounds");
  EXPECT_THAT(ViolatedInvariants(refined.state), IsEmpty());
  ASSERT_THAT(refined.state.objects(), SizeIs(2));
  const auto upper = std::ranges::find_if(refined.state.objects(), [](const HypothesisPtr& one) {
    return one->resting.on.has_value();
  });
  ASSERT_NE(upper, refined.state.objects().end());
  EXPECT_NEAR((*upper)->resting.foot_height_m, 0.06, 0.004);
}

TEST(SplitStackedRounds, MakesTwoOfACupOnACan) {
  HandBuilt scene;
  const Placed<> low = Standing(Cylinder{0.035, 0.09}, 0, 0);
  const Placed<> high = Standing(Cone{0.035, 0.055, 0.07}, 0, 0, 0.09);
  scene.Add({low, high});
  const RefinedScene refined = RunAlone(scene.StateWith({{low, high}}), "split.stacked_rounds");
  EXPECT_THAT(ViolatedInvariants(refined.state), IsEmpty());
  EXPECT_THAT(refined.state.objects(), SizeIs(2));
}

// A part that is too low or too slim to stand alone is a lid or a neck.
TEST(SplitStackedRounds, LeavesLidsAndNecksToTheirBodies) {
  for (const Cylinder& upper : {Cylinder{0.04, 0.012}, Cylinder{0.013, 0.06}}) {
    HandBuilt scene;
    const Placed<> body = Standing(Cylinder{0.035, 0.1}, 0, 0);
    const Placed<> top = Standing(upper, 0, 0, 0.1);
    scene.Add({body, top});
    EXPECT_THAT(ProposalsOf(scene.StateWith({{body, top}}), "split.stacked_rounds"), IsEmpty());
  }
}

TEST(SplitStackedRounds, RestsEachStoreyOnTheOneBelow) {
  HandBuilt scene;
  const std::vector<Placed<>> cans = {Standing(Cylinder{0.06, 0.05}, 0, 0),
                                      Standing(Cylinder{0.045, 0.06}, 0, 0, 0.05),
                                      Standing(Cylinder{0.03, 0.05}, 0, 0, 0.11)};
  const HypothesisId stack = scene.Add(cans);
  const SceneState state = scene.StateWith({cans});
  const std::vector<Proposal> proposals = ProposalsOf(state, "split.stacked_rounds");
  ASSERT_THAT(proposals, SizeIs(1));
  const std::vector<Product>& storeys = proposals.front().products;
  ASSERT_THAT(storeys, SizeIs(3));
  EXPECT_THAT(storeys[0].on_product, Eq(std::nullopt));
  EXPECT_THAT(storeys[1].on_product, Optional(0u));
  EXPECT_THAT(storeys[2].on_product, Optional(1u));
  EXPECT_NEAR(storeys[0].resting.foot_height_m, 0, 1e-9);
  EXPECT_NEAR(storeys[1].resting.foot_height_m, 0.05, 0.004);
  EXPECT_NEAR(storeys[2].resting.foot_height_m, 0.11, 0.004);
  EXPECT_EQ(proposals.front().consumes.front().successor,
            2u);  // what stood on it stands on the top
  PointSet all;
  for (const Product& storey : storeys) {
    all.insert(all.end(), storey.points.begin(), storey.points.end());
  }
  std::ranges::sort(all);
  EXPECT_EQ(all, state.Get(stack).points);
  // The top face of a can belongs to that can, although the next one begins at the same height.
  const auto is_lowest_top = [&](std::uint32_t i) {
    return state.points().normals[i].z() > 0.99f &&
           std::abs(state.points().points[i].z() - 0.05f) < 0.001f;
  };
  EXPECT_GT(std::ranges::count_if(storeys[0].points, is_lowest_top), 20);
  EXPECT_EQ(std::ranges::count_if(storeys[1].points, is_lowest_top), 0);
}

}  // namespace
}  // namespace cwm::perception
