#include "perception/hypotheses/scene_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "perception/hypotheses/invariants.h"

namespace cwm::perception {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

// Three objects of 3, 2 and 1 points and a residual of 4 on one support of 2; one point is
// rejected.
SegmentedScene SomeScene() {
  SegmentedScene scene;
  scene.points.points.resize(13);
  std::uint32_t next = 0;
  const auto take = [&next](std::size_t count) {
    PointSet points;
    for (std::size_t k = 0; k < count; ++k) points.push_back(next++);
    return points;
  };
  scene.supports.push_back({.plate = {}, .points = take(2)});
  for (const std::size_t count : {3u, 2u, 1u}) {
    SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
    hypothesis.supported_by = 0;
    hypothesis.points = take(count);
    hypothesis.node_count = count;
  }
  scene.hypotheses[2].rests_on = 0;
  scene.hypotheses[2].foot_height_m = 0.1;
  scene.hypotheses.emplace_back().points = take(4);
  scene.hypotheses.back().node_count = 4;
  scene.rejected = take(1);
  return scene;
}

TEST(SceneState, HasTheHypothesesOfASegmentation) {
  const SceneState state(SomeScene());
  EXPECT_THAT(state.hypotheses(), SizeIs(4));
  EXPECT_THAT(state.objects(), SizeIs(3));
  EXPECT_EQ(state.Get({2}).resting.on, HypothesisId{0});
  EXPECT_FALSE(state.Get({3}).IsObject());
  EXPECT_THAT(ViolatedInvariants(state), IsEmpty());
}

TEST(SceneState, KnowsTheGroundOfWhatRestsHigher) {
  const SceneState state(SomeScene());
  EXPECT_DOUBLE_EQ(X_LGround(state.measured(), state.Get({2}).resting)->translation().z(), 0.1);
  EXPECT_FALSE(X_LGround(state.measured(), state.Get({3}).resting).has_value());
}

TEST(SceneState, SharesWhatAChangeLeavesAlone) {
  const SceneState before(SomeScene());
  SceneState::Change change;
  change.removed = {{1}};
  change.added = {before.Get({1})};
  const HypothesisId id = before.NextId(0);
  const SceneState after = before.With(std::move(change));
  EXPECT_EQ(after.Find({1}), nullptr);
  EXPECT_EQ(&after.Get({0}), &before.Get({0}));
  EXPECT_EQ(after.Get(id).points, before.Get({1}).points);
  EXPECT_NE(before.Find({1}), nullptr);
  EXPECT_THAT(ViolatedInvariants(after), IsEmpty());
}

TEST(SceneState, KeepsTheOrderOfOutput) {
  const SceneState before(SomeScene());
  SceneState::Change change;
  change.removed = {{1}, {0}};
  ObjectHypothesis merged = before.Get({0});
  merged.points.insert(merged.points.end(), {5, 6});
  merged.node_count = 5;
  change.resting_updates = {{{2}, {.support = 0, .on = before.NextId(0), .foot_height_m = 0.1}}};
  change.added = {merged};
  const SceneState after = before.With(std::move(change));
  EXPECT_EQ(after.objects().front()->id, before.NextId(0));
  EXPECT_EQ(after.IndexOf({2}), 1u);
  EXPECT_THAT(ViolatedInvariants(after), IsEmpty());
}

TEST(SceneState, StandsOnTheSupportWhereItsModelReachesIt) {
  const SceneState before(SomeScene());
  auto model = std::make_shared<HypothesisModel>();
  model->reaches_support = true;
  model->object.part_of_point = {kUnexplained};
  std::vector<ModelPtr> models(before.hypotheses().size());
  models[before.IndexOf({2})] = model;
  const SceneState after = before.WithModels(models);
  EXPECT_FALSE(after.Get({2}).resting.on);
  EXPECT_EQ(after.Get({2}).resting.foot_height_m, 0);
}

TEST(ViolatedInvariants, TellOfPointsWithoutAnOwnerAndWithTwo) {
  SegmentedScene scene = SomeScene();
  scene.hypotheses[0].points.pop_back();
  scene.hypotheses[1].points.push_back(0);  // belongs to the support
  const auto broken = ViolatedInvariants(SceneState(std::move(scene)));
  ASSERT_THAT(broken, SizeIs(2));
  EXPECT_THAT(broken[0], HasSubstr("no owner"));
  EXPECT_THAT(broken[1], HasSubstr("several owners"));
}

TEST(ViolatedInvariants, TellOfWhatRestsOnNothingThatLives) {
  const SceneState before(SomeScene());
  SceneState::Change change;
  change.removed = {{0}};
  change.added = {before.Get({0})};
  const auto broken = ViolatedInvariants(before.With(std::move(change)));
  ASSERT_THAT(broken, SizeIs(1));
  EXPECT_THAT(broken[0], HasSubstr("is gone"));
}

TEST(ViolatedInvariants, TellOfCircles) {
  SegmentedScene scene = SomeScene();
  scene.hypotheses[0].rests_on = 2;
  const auto broken = ViolatedInvariants(SceneState(std::move(scene)));
  EXPECT_THAT(broken, ::testing::Contains(HasSubstr("rests on itself")));
}

TEST(ViolatedInvariants, TellOfLabelsThatDoNotFit) {
  const SceneState before(SomeScene());
  auto model = std::make_shared<HypothesisModel>();
  model->object.part_of_point = {0};
  std::vector<ModelPtr> models(before.hypotheses().size());
  models[before.IndexOf({0})] = model;
  EXPECT_THAT(ViolatedInvariants(before.WithModels(models)), SizeIs(2));
}

}  // namespace
}  // namespace cwm::perception
