// Each pass alone, on hypotheses that are put together by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "perception/hypotheses/invariants.h"
#include "perception/refinement/passes.h"
#include "tests/perception/refinement/hand_built.h"

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

int Committed(const RefinedScene& refined) {
  return static_cast<int>(
      std::ranges::count(refined.trials, Trial::Outcome::kCommitted, &Trial::outcome));
}

void ExpectSound(const RefinedScene& refined) {
  EXPECT_THAT(ViolatedInvariants(refined.state), IsEmpty());
}

TEST(AllPasses, AreInTheOrderThatTheyDeclare) {
  EXPECT_THAT(PassesOutOfOrder(RefinementPasses()), IsEmpty());
}

TEST(AllPasses, HaveNamesOfTheirOwn) {
  std::vector<std::string> names = PassNames();
  std::ranges::sort(names);
  EXPECT_EQ(std::ranges::adjacent_find(names), names.end());
}

// A rod that lies behind a post; both of its ends are seen.
class RodBehindAPost : public ::testing::Test {
 protected:
  static Placed<> Rod(double from_m, double to_m, double radius_m) {
    Pose X_LS = Pose::Identity();
    X_LS.translation() = Vector3(0.15, 0.5 * (from_m + to_m), radius_m);
    X_LS.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitX()));
    return {X_LS, Cylinder{radius_m, to_m - from_m}};
  }
  static Placed<> Post() { return Standing(Box{{0.04, 0.08, 0.25}}, -0.05, -0.02); }
};

TEST_F(RodBehindAPost, IsMerged) {
  HandBuilt scene;
  scene.AddOccluder(Post());
  scene.Add({Rod(-0.2, 0.01, 0.02)});
  scene.Add({Rod(0.1, 0.25, 0.02)});
  const RefinedScene refined = RunAlone(scene.Modelled(), "merge.occluded_parts");
  ExpectSound(refined);
  EXPECT_EQ(Committed(refined), 1);
  EXPECT_THAT(refined.state.objects(), SizeIs(2));
}

TEST_F(RodBehindAPost, IsNotMergedWithAThickerOne) {
  HandBuilt scene;
  scene.AddOccluder(Post());
  scene.Add({Rod(-0.2, 0.01, 0.02)});
  scene.Add({Rod(0.1, 0.25, 0.035)});
  EXPECT_THAT(RunAlone(scene.Modelled(), "merge.occluded_parts").state.objects(), SizeIs(3));
}

TEST(SplitStandingSolids, MakesTwoOfCansThatTouch) {
  HandBuilt scene;
  const Placed<> one = Standing(Cylinder{0.035, 0.11}, 0, 0);
  const Placed<> other = Standing(Cylinder{0.03, 0.09}, 0, 0.066);
  scene.Add({one, other});
  const RefinedScene refined = RunAlone(scene.StateWith({{one, other}}), "split.standing_solids");
  ExpectSound(refined);
  EXPECT_THAT(refined.state.objects(), SizeIs(2));
}

TEST(SplitStandingSolids, LeavesOneRodOfTwoPieces) {
  HandBuilt scene;
  Pose X_LS = Pose::Identity();
  X_LS.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitX()));
  X_LS.translation() = Vector3(0, -0.05, 0.02);
  const Placed<> one{X_LS, Cylinder{0.02, 0.1}};
  X_LS.translation() = Vector3(0, 0.05, 0.02);
  const Placed<> other{X_LS, Cylinder{0.02, 0.1}};
  scene.Add({one, other});
  EXPECT_THAT(ProposalsOf(scene.StateWith({{one, other}}), "split.standing_solids"), IsEmpty());
}

// An object that rested on the split object rests on the part below it.
TEST(SplitStandingSolids, ReseatsWhatRestedOnThem) {
  HandBuilt scene;
  const Placed<> low = Standing(Box{{0.08, 0.08, 0.06}}, 0, 0);
  const Placed<> high = Standing(Box{{0.08, 0.08, 0.12}}, 0, 0.085, 0, 0.3);
  const Placed<> ball = Standing(Sphere{0.025}, 0, 0.085, 0.12);
  const HypothesisId both = scene.Add({low, high});
  const HypothesisId upper = scene.Add({ball});
  scene.Rest(upper, both, 0.12);
  const RefinedScene refined =
      RunAlone(scene.StateWith({{low, high}, {ball}}), "split.standing_solids");
  ExpectSound(refined);
  ASSERT_THAT(refined.state.objects(), SizeIs(3));
  const ObjectHypothesis& carried = refined.state.Get(upper);
  ASSERT_TRUE(carried.resting.on);
  const ObjectHypothesis& below = refined.state.Get(*carried.resting.on);
  EXPECT_GT(below.model->bounds_L.max().z(), 0.11f);
}

TEST(SplitStackedBoxes, MakesTwoOfAStack) {
  HandBuilt scene;
  const Placed<> low = Standing(Box{{0.16, 0.12, 0.04}}, 0, 0);
  const Placed<> high = Standing(Box{{0.15, 0.11, 0.05}}, 0, 0, 0.04, 0.4);
  scene.Add({low, high});
  const RefinedScene refined = RunAlone(scene.StateWith({{low, high}}), "split.stacked_boxes");
  ExpectSound(refined);
  ASSERT_THAT(refined.state.objects(), SizeIs(2));
  const auto upper = std::ranges::find_if(refined.state.objects(), [](const HypothesisPtr& one) {
    return one->resting.on.has_value();
  });
  ASSERT_NE(upper, refined.state.objects().end());
  EXPECT_NEAR((*upper)->resting.foot_height_m, 0.04, 0.003);
}

TEST(SplitStackedBoxes, LeavesOneBoxAlone) {
  HandBuilt scene;
  const Placed<> box = Standing(Box{{0.16, 0.12, 0.09}}, 0, 0);
  scene.Add({box});
  EXPECT_THAT(ProposalsOf(scene.StateWith({{box}}), "split.stacked_boxes"), IsEmpty());
}

// Points of one hypothesis that the other explains change their owner.
TEST(ReassignPoints, GivesPointsBackToTheirSolid) {
  HandBuilt scene;
  const Placed<> can = Standing(Cylinder{0.035, 0.11}, 0, 0);
  const Placed<> box = Standing(Box{{0.07, 0.06, 0.09}}, 0, -0.07);
  scene.Add({can});
  scene.Add({box});
  const SceneState right = scene.StateWith({{can}, {box}});
  const ObjectHypothesis& owner = right.Get(HypothesisId{0});
  const ObjectHypothesis& other = right.Get(HypothesisId{1});
  // A strip of the can is assigned to the box.
  SceneState::Change change;
  ObjectHypothesis less = owner, more = other;
  PointSet strip;
  for (std::size_t k = 0; k < 120; ++k) strip.push_back(owner.points[k]);
  std::erase_if(less.points, [&](std::uint32_t i) { return std::ranges::count(strip, i) > 0; });
  more.points.insert(more.points.end(), strip.begin(), strip.end());
  std::ranges::sort(more.points);
  less.node_count = less.points.size(), more.node_count = more.points.size();
  change.removed = {owner.id, other.id};
  const auto relabel = [&](ObjectHypothesis& changed, const PointSet& own) {
    auto model = std::make_shared<HypothesisModel>(*changed.model);
    model->object.part_of_point.clear();
    for (std::uint32_t i : changed.points) {
      model->object.part_of_point.push_back(std::ranges::binary_search(own, i) ? 0 : kUnexplained);
    }
    changed.model = model;
  };
  relabel(less, owner.points);
  relabel(more, other.points);
  change.added = {less, more};
  const RefinedScene refined = RunAlone(right.With(change), "reassign.points");
  ExpectSound(refined);
  EXPECT_EQ(Committed(refined), 1);
  const bool returned = std::ranges::any_of(refined.state.objects(), [&](const HypothesisPtr& one) {
    return one->points == owner.points;
  });
  EXPECT_TRUE(returned);
}

// Four walls, two of which show their insides.
TEST(MergeTrayWalls, MakesATrayOfItsWalls) {
  constexpr double kThick_m = 0.004, kHigh_m = 0.08;
  const Placed<> back = Standing(Box{{kThick_m, 0.3, kHigh_m}}, 0.1, 0);
  const Placed<> front = Standing(Box{{kThick_m, 0.3, kHigh_m}}, -0.1, 0);
  const Placed<> left = Standing(Box{{0.2, kThick_m, kHigh_m}}, 0, 0.15);
  const Placed<> right = Standing(Box{{0.2, kThick_m, kHigh_m}}, 0, -0.15);
  HandBuilt scene;
  scene.Add({back});
  scene.Add({front});
  scene.Add({left});
  scene.Add({right});
  const RefinedScene refined =
      RunAlone(scene.StateWith({{back}, {front}, {left}, {right}}), "merge.tray_walls");
  ExpectSound(refined);
  ASSERT_THAT(refined.state.objects(), SizeIs(1));
  EXPECT_TRUE(refined.state.objects().front()->model->is_given);
  EXPECT_GE(refined.state.objects().front()->model->shapes().size(), 4u);
}

TEST(MergeTrayWalls, LeavesSolidBoxesAlone) {
  HandBuilt scene;
  const Placed<> one = Standing(Box{{0.06, 0.3, 0.08}}, 0.13, 0);
  const Placed<> other = Standing(Box{{0.06, 0.3, 0.08}}, -0.13, 0);
  scene.Add({one});
  scene.Add({other});
  EXPECT_THAT(ProposalsOf(scene.StateWith({{one}, {other}}), "merge.tray_walls"), IsEmpty());
}

// A bar that is seen on both sides of a post; one half is taken for a handle of the object beside
// it.
TEST(ReturnHandles, GivesARodsEndBack) {
  HandBuilt scene;
  const auto rod = [](double from_m, double to_m) {
    Pose X_LS = Pose::Identity();
    X_LS.translation() = Vector3(0.15, 0.5 * (from_m + to_m), 0.02);
    X_LS.rotate(Eigen::AngleAxisd(0.5 * std::numbers::pi, Vector3::UnitX()));
    return Placed<>{X_LS, Cylinder{0.02, to_m - from_m}};
  };
  scene.AddOccluder(Standing(Box{{0.04, 0.08, 0.25}}, -0.05, -0.02));
  const Placed<> far = rod(0.1, 0.25), near = rod(-0.12, 0.01);
  const Placed<> can = Standing(Cylinder{0.035, 0.1}, 0.15, -0.157);
  scene.Add({far});
  scene.Add({can, near});
  SceneState state =
      scene.StateWith({{Standing(Box{{0.04, 0.08, 0.25}}, -0.05, -0.02)}, {far}, {can, near}});
  std::vector<ModelPtr> models(state.hypotheses().size());
  const std::size_t at = state.IndexOf({2});
  auto model = std::make_shared<HypothesisModel>(*state.Get({2}).model);
  model->object.shapes.pop_back();
  model->object.handles.emplace_back();
  models[at] = model;
  state = state.WithModels(models);
  const RefinedScene refined = RunAlone(state, "reassign.handles");
  ExpectSound(refined);
  EXPECT_EQ(Committed(refined), 1);
}

}  // namespace
}  // namespace cwm::perception
