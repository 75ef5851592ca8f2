#include "perception/refinement/evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr float kBallSigma_m = 0.002f;

ShapePart BallAt(double x_m, double radius_m) {
  return {.X_OS = MakeTranslation(x_m, 0, 0), .shape = Sphere{radius_m}};
}

void AddPointAt(const Vector3& p, OrientedPoints& points) {
  points.points.push_back(p.cast<float>());
  points.normals.push_back(Eigen::Vector3f::UnitZ());
  points.sigma_m.push_back(kBallSigma_m);
  points.normal_sigma_rad.push_back(0.05f);
  points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
}

TEST(MisfitOf, IsTheMeanSquareToTheNearestSurfaceAndNineAtMost) {
  // The surface of the small ball lies inside the large one.
  const std::vector<ShapePart> balls = {BallAt(0, 1), BallAt(0.5, 0.1)};
  const Vector3 on_small(0.5, 0, 0.1);
  EXPECT_NEAR(DistanceToShapes_m(balls, on_small + Vector3(0, 0, 0.05)), 0.05, 1e-9);
  EXPECT_EQ(NearestShape(balls, on_small + Vector3(0, 0, 0.05)), 1u);
  EXPECT_EQ(NearestShape(balls, {-0.9, 0, 0}), 0u);
  EXPECT_TRUE(std::isinf(DistanceToShapes_m({}, on_small)));
  OrientedPoints points;
  AddPointAt(on_small, points);
  AddPointAt(on_small + Vector3(0, 0, 0.004), points);  // two standard deviations out
  AddPointAt(on_small - Vector3(0, 0, 0.002), points);  // one in
  AddPointAt({0, 3, 0}, points);
  EXPECT_NEAR(MisfitOf(balls, {0, 1, 2, 3}, points), (0 + 4 + 1 + 9) / 4.0, 1e-3);
  EXPECT_NEAR(MisfitOf(balls, {1, 2}, points), (4 + 1) / 2.0, 1e-3);
  EXPECT_DOUBLE_EQ(MisfitOf({}, {0, 1}, points), 9);
}

// Two balls of 5 cm, of 48 points each, as two objects.
SceneState TwoBalls() {
  SegmentedScene scene;
  scene.supports.emplace_back();
  std::vector<ModelPtr> models;
  for (const double x_m : {0.0, 0.3}) {
    SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
    hypothesis.supported_by = 0;
    for (int k = 0; k < 48; ++k) {
      const double angle_rad = 2 * std::numbers::pi * k / 48;
      hypothesis.points.push_back(static_cast<std::uint32_t>(scene.points.size()));
      AddPointAt({x_m + 0.05 * std::cos(angle_rad), 0.05 * std::sin(angle_rad), 0}, scene.points);
    }
    hypothesis.node_count = hypothesis.points.size();
    auto model = std::make_shared<HypothesisModel>();
    model->object.shapes = {BallAt(x_m, 0.05)};
    model->object.part_of_point.assign(hypothesis.points.size(), 0);
    models.push_back(std::move(model));
  }
  return SceneState(std::move(scene)).WithModels(models);
}

TEST(ExplainsAllParts, AsksThatEveryPartFitsNearlyAsWellAsBefore) {
  const SceneState state = TwoBalls();
  const HypothesisModeler modeler(state.measured(), kSerialWork);
  const ModelingOptions options;
  const RefinementContext context{.options = options, .modeler = modeler, .work = kSerialWork};
  const std::array<HypothesisId, 2> both = {HypothesisId{0}, HypothesisId{1}};
  Proposal merge;
  merge.consumes = {{both[0]}, {both[1]}};
  merge.products = {Merged(state, both)};
  EXPECT_EQ(CountPoints(state, merge), 96u);
  const auto accounts = [&](const std::vector<ShapePart>& shapes) {
    auto model = std::make_shared<HypothesisModel>();
    model->object.shapes = shapes;
    const std::array<ModelPtr, 1> product = {model};
    return ExplainsAllParts({state, merge, product, context});
  };
  EXPECT_TRUE(accounts({BallAt(0, 0.05), BallAt(0.3, 0.05)}));
  EXPECT_TRUE(accounts({BallAt(0, 0.05), BallAt(0.3, 0.051)}));   // a quarter of sigma squared
  EXPECT_FALSE(accounts({BallAt(0, 0.05), BallAt(0.3, 0.052)}));  // one sigma squared
  EXPECT_FALSE(accounts({BallAt(0, 0.05)}));
  EXPECT_FALSE(accounts({BallAt(0.3, 0.05)}));
}

TEST(Merged, KeepsAllPointsInOrderAndStandsOnTheLowestGround) {
  SegmentedScene scene;
  scene.points.points.resize(7);
  scene.supports.emplace_back();
  for (const PointSet& points : {PointSet{1, 4}, PointSet{0, 5}, PointSet{2, 3}, PointSet{6}}) {
    SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
    hypothesis.supported_by = 0;
    hypothesis.points = points;
    hypothesis.node_count = 10 * points.size();
  }
  scene.hypotheses[0].rests_on = 2;
  scene.hypotheses[0].foot_height_m = 0.2;
  scene.hypotheses[1].foot_height_m = 0.1;
  scene.hypotheses[3].supported_by = -1;  // residual geometry has no ground
  const SceneState state(std::move(scene));
  const std::array<HypothesisId, 2> two = {HypothesisId{0}, HypothesisId{1}};
  const Product merged = Merged(state, two);
  EXPECT_THAT(merged.points, ElementsAre(0, 1, 4, 5));
  EXPECT_EQ(merged.node_count, 40u);
  EXPECT_EQ(merged.resting.support, 0);
  EXPECT_EQ(merged.resting.foot_height_m, 0.1);
  EXPECT_FALSE(merged.resting.on.has_value());
  const std::array<HypothesisId, 2> with_residual = {HypothesisId{0}, HypothesisId{3}};
  const Product raised = Merged(state, with_residual);
  EXPECT_THAT(raised.points, ElementsAre(1, 4, 6));
  EXPECT_EQ(raised.resting.foot_height_m, 0.2);
  EXPECT_EQ(raised.resting.on, HypothesisId{2});
}

TEST(PointsOfPart, AreGivenAwayAndTakenBackWithTheirNodes) {
  auto model = std::make_shared<HypothesisModel>();
  model->object.shapes = {BallAt(0, 0.05), BallAt(0.3, 0.05)};
  model->object.handles.resize(1);
  model->object.part_of_point = {0, 1, 2, kUnexplained, 2};
  ObjectHypothesis hypothesis;
  hypothesis.points = {3, 5, 7, 8, 9};
  hypothesis.node_count = 15;
  hypothesis.resting = {.support = 0, .on = HypothesisId{4}, .foot_height_m = 0.1};
  hypothesis.model = model;
  EXPECT_THAT(PointsOfPart(hypothesis, 1), ElementsAre(5));
  EXPECT_THAT(PointsOfPart(hypothesis, kUnexplained), ElementsAre(8));
  EXPECT_THAT(PointsOfPart(hypothesis, 3), IsEmpty());
  const PointSet handle = PointsOfHandle(hypothesis, 0);
  EXPECT_THAT(handle, ElementsAre(7, 9));
  const Product less = Without(hypothesis, handle);
  EXPECT_THAT(less.points, ElementsAre(3, 5, 8));
  EXPECT_EQ(less.node_count, 9u);
  EXPECT_EQ(less.resting.on, HypothesisId{4});
  const Product more = With(hypothesis, {4, 12}, 2);
  EXPECT_THAT(more.points, ElementsAre(3, 4, 5, 7, 8, 9, 12));
  EXPECT_EQ(more.node_count, 17u);
  EXPECT_EQ(more.resting.foot_height_m, 0.1);
  EXPECT_THAT(Without(hypothesis, hypothesis.points).points, IsEmpty());
}

}  // namespace
}  // namespace cwm::perception
