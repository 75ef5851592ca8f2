#include "perception/refinement/split/split_rows.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "perception/hypotheses/invariants.h"
#include "tests/perception/refinement/hand_built.h"

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;

// Packets of one height, seen as one box; one of them stands back by some millimetres.
TEST(SplitRows, CutsWhereTheFrontJumps) {
  HandBuilt scene;
  const Placed<> left = Standing(Box{{0.08, 0.09, 0.12}}, 0.008, 0.045);
  const Placed<> right = Standing(Box{{0.08, 0.09, 0.12}}, 0, -0.045);
  const Placed<> both = Standing(Box{{0.08, 0.18, 0.12}}, 0.004, 0);
  scene.Add({left, right});
  const RefinedScene refined = RunAlone(scene.StateWith({{both}}), "split.rows");
  EXPECT_THAT(ViolatedInvariants(refined.state), IsEmpty());
  ASSERT_THAT(refined.state.objects(), SizeIs(2));
  for (const HypothesisPtr& object : refined.state.objects()) {
    ASSERT_THAT(object->model->shapes(), SizeIs(1));
    const auto* box = std::get_if<Box>(&object->model->shapes().front().shape);
    ASSERT_NE(box, nullptr);
    EXPECT_NEAR(box->size_m.z(), 0.12, 0.004);
  }
}

TEST(SplitRows, LeavesFlushBoxesAndRoundObjectsAlone) {
  for (const Shape& shape : {Shape(Box{{0.08, 0.18, 0.12}}), Shape(Cylinder{0.06, 0.1})}) {
    HandBuilt scene;
    const Placed<> one = Standing(shape, 0, 0);
    scene.Add({one});
    EXPECT_THAT(ProposalsOf(scene.StateWith({{one}}), "split.rows"), IsEmpty());
  }
}

// Three packets, each of which stands back behind the one before.
TEST(SplitRows, CutsAtEverySeamAndLosesNoPoint) {
  HandBuilt scene;
  std::vector<Placed<>> packets;
  for (const int k : {0, 1, 2}) {
    packets.push_back(Standing(Box{{0.08, 0.09, 0.12}}, 0.008 * k, 0.09 * k));
  }
  const HypothesisId row = scene.Add(packets);
  const SceneState state = scene.StateWith({{Standing(Box{{0.09, 0.27, 0.12}}, 0.008, 0.09)}});
  const std::vector<Proposal> proposals = ProposalsOf(state, "split.rows");
  ASSERT_THAT(proposals, Not(IsEmpty()));
  const std::vector<Product>& products = proposals.front().products;
  ASSERT_THAT(products, SizeIs(3));
  PointSet all;
  std::vector<std::pair<float, float>> ranges_m;  // across the row
  for (const Product& product : products) {
    EXPECT_EQ(product.node_count, product.points.size());  // as of the whole
    ASSERT_THAT(product.points, Not(IsEmpty()));
    all.insert(all.end(), product.points.begin(), product.points.end());
    const auto across = [&](std::uint32_t i) { return state.points().points[i].y(); };
    const auto [low, high] = std::ranges::minmax_element(product.points, {}, across);
    ranges_m.emplace_back(across(*low), across(*high));
  }
  std::ranges::sort(all);
  EXPECT_EQ(all, state.Get(row).points);
  std::ranges::sort(ranges_m);
  for (const std::size_t k : {0u, 1u, 2u}) {
    const double from_m = 0.09 * static_cast<double>(k) - 0.045;
    EXPECT_GT(ranges_m[k].first, from_m - 0.004);  // a step of the front
    EXPECT_LT(ranges_m[k].second, from_m + 0.09 + 0.004);
  }
}

}  // namespace
}  // namespace cwm::perception
