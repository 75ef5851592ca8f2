#include "perception/refinement/criterion.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

namespace cwm::perception {
namespace {

constexpr float kClaimed_m = 0.002f;
const SensorNoise kWithoutWarp{.model = SensorModel::kGiven, .given_sigma_m = 0.002};

ShapePart SphereAround(const Vector3& middle) {
  return {.X_OS = MakeTranslation(middle.x(), middle.y(), middle.z()), .shape = Sphere{0.1}};
}

const std::vector<ShapePart> kOneSphere = {SphereAround(Vector3::Zero())};

// `count` points, all at the distance `off_m` from the sphere around the origin.
OrientedPoints OffSphere(std::size_t count, float off_m) {
  OrientedPoints points;
  points.points.assign(count, Eigen::Vector3f(0, 0, 0.1f + off_m));
  points.normals.assign(count, Eigen::Vector3f::UnitZ());
  points.sigma_m.assign(count, kClaimed_m);
  points.normal_sigma_rad.assign(count, 0.05f);
  points.cloud_index.resize(count);
  std::iota(points.cloud_index.begin(), points.cloud_index.end(), 0u);
  return points;
}

PointSet FirstOf(std::size_t count) {
  PointSet first(count);
  std::iota(first.begin(), first.end(), 0u);
  return first;
}

TEST(CostOf, IsHalfOfTheSquaresPerSampleAndOfWhatTheParametersCost) {
  const OrientedPoints all = OffSphere(120, 2 * kClaimed_m);  // ten samples
  const double of_ten = std::log(10.0);
  EXPECT_NEAR(CostOf(kOneSphere, FirstOf(120), all, kWithoutWarp), 0.5 * (40 + 9 * of_ten), 1e-3);
  EXPECT_NEAR(CostOf(kOneSphere, FirstOf(60), all, kWithoutWarp), 0.5 * (20 + 9 * of_ten), 1e-3);
  // Another solid, far away, costs its six parameters.
  const std::vector<ShapePart> two = {kOneSphere.front(), SphereAround({1, 0, 0})};
  EXPECT_NEAR(CostOf(two, FirstOf(120), all, kWithoutWarp), 0.5 * (40 + 15 * of_ten), 1e-3);
  // Points of a sensor that warps are given less weight.
  const double square = 0.004 * 0.004 / (0.002 * 0.002 + kSlowWarp_m * kSlowWarp_m);
  EXPECT_NEAR(CostOf(kOneSphere, FirstOf(120), all, {.model = SensorModel::kKinect}),
              0.5 * (10 * square + 9 * of_ten), 1e-3);
}

TEST(CostOf, CountsNinePerPointWhereNoShapeIsNear) {
  // More points than are evaluated one by one.
  const OrientedPoints many = OffSphere(1200, 0);
  EXPECT_NEAR(CostOf({}, FirstOf(1200), many, kWithoutWarp), 0.5 * (900 + 3 * std::log(100.0)),
              1e-3);
  // A scene counts as at least two samples.
  const OrientedPoints few = OffSphere(6, 0);
  EXPECT_NEAR(CostOf({}, FirstOf(6), few, kWithoutWarp), 0.5 * (4.5 + 3 * std::log(2.0)), 1e-3);
}

ModelPtr OfShapes(const std::vector<ShapePart>& shapes, std::size_t count) {
  auto model = std::make_shared<HypothesisModel>();
  model->object.shapes = shapes;
  model->object.part_of_point.assign(count, 0);
  return model;
}

TEST(CriterionGain, IsWhatTwoObjectsCostMoreThanTheOneThatExplainsThemBoth) {
  SegmentedScene scene;
  scene.points = OffSphere(120, 0);
  scene.supports.emplace_back();
  for (const std::uint32_t first : {0u, 60u}) {
    SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
    hypothesis.supported_by = 0;
    hypothesis.points.resize(60);
    std::iota(hypothesis.points.begin(), hypothesis.points.end(), first);
    hypothesis.node_count = 60;
  }
  const std::array apart = {OfShapes(kOneSphere, 60), OfShapes(kOneSphere, 60)};
  const SceneState state = SceneState(std::move(scene)).WithModels(apart);
  const HypothesisModeler modeler(state.measured(), kSerialWork);
  const ModelingOptions options;
  const RefinementContext context{.options = options, .modeler = modeler, .work = kSerialWork};
  Proposal merge;
  merge.consumes = {{{0}}, {{1}}};
  merge.products.resize(1);
  merge.products.front().points = FirstOf(120);
  const auto gain_of = [&](const std::vector<ShapePart>& shapes) {
    const std::array product = {OfShapes(shapes, 120)};
    return CriterionGain({state, merge, product, context});
  };
  // Nine parameters fewer.
  const double saved = 0.5 * 9 * std::log(10.0);
  EXPECT_NEAR(gain_of(kOneSphere), saved, 1e-3);
  // Nine parameters fewer, and ten samples that no shape explains any more.
  EXPECT_NEAR(gain_of({SphereAround({1, 0, 0})}), saved - 0.5 * 90, 1e-3);
}

}  // namespace
}  // namespace cwm::perception
