// Each shape model compared with its definition: distances, gradients, minimal samples, box tests
// and refinement.
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "perception/fit/refine.h"
#include "perception/search/any_model.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kRounding = 1e-9;

Vector3 RandomVector(RandomDraws& draws, double size) {
  return size * Vector3{draws.Uniform(-1, 1), draws.Uniform(-1, 1), draws.Uniform(-1, 1)};
}
Vector3 RandomUnit(RandomDraws& draws) {
  return Vector3{draws.Normal(), draws.Normal(), draws.Normal()}.normalized();
}

template <class M>
M RandomModel(RandomDraws& draws);
template <>
PlaneModel RandomModel(RandomDraws& draws) {
  return {.point = RandomVector(draws, 0.1), .normal = RandomUnit(draws)};
}
template <>
SphereModel RandomModel(RandomDraws& draws) {
  return {.center = RandomVector(draws, 0.1), .radius_m = draws.Uniform(0.02, 0.1)};
}
template <>
CylinderModel RandomModel(RandomDraws& draws) {
  return {.point = RandomVector(draws, 0.1),
          .axis = RandomUnit(draws),
          .radius_m = draws.Uniform(0.02, 0.1)};
}
template <>
ConeModel RandomModel(RandomDraws& draws) {
  return {.point = RandomVector(draws, 0.1),
          .axis = RandomUnit(draws),
          .radius_m = draws.Uniform(0.02, 0.1),
          .slope = draws.Uniform(-0.5, 0.5)};
}

// A point of the surface within 5 cm of its reference plane and within 60 degrees of one side.
template <class M>
Vector3 SurfacePointOf(const M& model, RandomDraws& draws) {
  if constexpr (std::is_same_v<M, PlaneModel>) {
    const Matrix3 basis = BasisFromZ(model.normal);
    return model.point +
           basis.leftCols<2>() * Vector2{draws.Uniform(-0.1, 0.1), draws.Uniform(-0.1, 0.1)};
  } else if constexpr (std::is_same_v<M, SphereModel>) {
    return model.center +
           model.radius_m * (Vector3::UnitX() + 0.8 * RandomVector(draws, 1)).normalized();
  } else {
    const double height_m = draws.Uniform(-0.03, 0.03);
    const double angle = draws.Uniform(-1, 1);
    double radius_m = model.radius_m;
    if constexpr (std::is_same_v<M, ConeModel>) radius_m = model.RadiusAt_m(height_m);
    const Matrix3 basis = BasisFromZ(model.axis);
    return model.point + height_m * model.axis +
           radius_m * (std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(1));
  }
}

template <class M>
class ShapeModelLaws : public ::testing::Test {};
using Models = ::testing::Types<PlaneModel, SphereModel, CylinderModel, ConeModel>;
TYPED_TEST_SUITE(ShapeModelLaws, Models);

TYPED_TEST(ShapeModelLaws, DistanceVanishesOnTheSurfaceAndGrowsAlongTheNormal) {
  RandomDraws draws(1, 0);
  for (int trial = 0; trial < 100; ++trial) {
    const auto model = RandomModel<TypeParam>(draws);
    const Vector3 p = SurfacePointOf(model, draws);
    EXPECT_NEAR(model.Distance_m(p), 0, kRounding);
    EXPECT_NEAR(model.Distance_m(p + 0.01 * model.Normal(p)), 0.01, kRounding);
    EXPECT_NEAR(model.Normal(p).norm(), 1, kRounding);
  }
}

TYPED_TEST(ShapeModelLaws, GradientIsTheDerivativeOfTheDistance) {
  constexpr double kStep = 1e-6;
  constexpr double kSecondOrder = 1e-4;  // step times curvature, 1 / 20 mm, and its square
  RandomDraws draws(2, 0);
  for (int trial = 0; trial < 50; ++trial) {
    const auto model = RandomModel<TypeParam>(draws);
    const Vector3 p = SurfacePointOf(model, draws) + RandomVector(draws, 0.005);
    const auto gradient = model.Gradient(p);
    for (int k = 0; k < TypeParam::kParameterCount; ++k) {
      typename TypeParam::Parameters step = TypeParam::Parameters::Zero();
      step(k) = kStep;
      const double difference = (model.Moved(step).Distance_m(p) - model.Distance_m(p)) / kStep;
      EXPECT_NEAR(gradient(k), difference, kSecondOrder) << "parameter " << k;
    }
  }
}

TYPED_TEST(ShapeModelLaws, MinimalSampleGivesTheSurfaceBack) {
  constexpr double kAmplified = 1e-6;  // rounding, amplified by nearly parallel normals
  RandomDraws draws(3, 0);
  int found = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const auto model = RandomModel<TypeParam>(draws);
    typename TypeParam::Sample sample;
    for (SamplePoint& s : sample) {
      const Vector3 p = SurfacePointOf(model, draws);
      s = {p, model.Normal(p)};
    }
    const std::optional<TypeParam> again = TypeParam::FromSample(sample);
    if (!again) continue;  // an ill-conditioned sample
    ++found;
    for (int k = 0; k < 10; ++k) {
      EXPECT_NEAR(again->Distance_m(SurfacePointOf(model, draws)), 0, kAmplified);
    }
  }
  EXPECT_GE(found, 80);
}

TYPED_TEST(ShapeModelLaws, BoxTestNeverLosesAPointWithinTheGate) {
  RandomDraws draws(4, 0);
  constexpr double kGate_m = 0.004;
  int reached = 0, pruned = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto model = RandomModel<TypeParam>(draws);
    CellBounds box;
    box.center = SurfacePointOf(model, draws) + RandomVector(draws, 0.05);
    box.half_m = RandomVector(draws, 0.02).cwiseAbs();
    bool inside_gate = false;
    for (int k = 0; k < 60 && !inside_gate; ++k) {
      const Vector3 p = box.center + RandomVector(draws, 1).cwiseProduct(box.half_m);
      inside_gate = std::abs(model.Distance_m(p)) <= kGate_m;
    }
    const bool may_reach = model.MayReach(box, kGate_m);
    EXPECT_TRUE(may_reach || !inside_gate);
    reached += inside_gate ? 1 : 0;
    pruned += may_reach ? 0 : 1;
  }
  EXPECT_GT(reached, 300);  // the test saw both sides
  EXPECT_GT(pruned, 300);
}

// Pruning pays only if boxes that lie entirely inside a shape are pruned like those outside. A
// distance changes by at most the length of a step, so a box farther away than the gate plus its
// half diagonal holds no inlier, and every box test can detect that.
TYPED_TEST(ShapeModelLaws, BoxTestPrunesWhatIsClearOfTheShellOnEitherSide) {
  RandomDraws draws(9, 0);
  constexpr double kGate_m = 0.004;
  int outside = 0, inside = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const auto model = RandomModel<TypeParam>(draws);
    CellBounds box;
    box.center = SurfacePointOf(model, draws) + RandomVector(draws, 0.05);
    box.half_m = RandomVector(draws, 0.004).cwiseAbs();
    const double distance_m = model.Distance_m(box.center);
    if (std::abs(distance_m) <= kGate_m + box.half_m.norm()) continue;
    EXPECT_FALSE(model.MayReach(box, kGate_m)) << trial;
    (distance_m > 0 ? outside : inside) += 1;
  }
  EXPECT_GT(outside, 300);  // the test saw both sides
  EXPECT_GT(inside, 300);
}

TYPED_TEST(ShapeModelLaws, RefinementRecoversTheSurfaceWithinThreeSigma) {
  constexpr double kSigma_m = 0.001;
  constexpr int kPoints = 400;
  RandomDraws draws(5, 0);
  RandomDraws noise(6, 0);
  for (int trial = 0; trial < 20; ++trial) {
    const auto truth = RandomModel<TypeParam>(draws);
    ModelPoints points;
    std::vector<std::uint32_t> all;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const Vector3 p = SurfacePointOf(truth, draws);
      points.p.push_back(p + kSigma_m * noise.Normal() * truth.Normal(p));
      points.n.push_back(truth.Normal(p));
      points.sigma_m.push_back(kSigma_m);
      all.push_back(i);
    }
    typename TypeParam::Parameters step = TypeParam::Parameters::Constant(0.01);
    const auto refined = Refine(truth.Moved(step), points, all, RefineOptions{});
    ASSERT_TRUE(refined);
    // At the points, the surface errs by sigma sqrt(k / n) on average (least squares).
    double squares = 0;
    for (std::uint32_t i : all) {
      const double error_m = refined->model.Distance_m(points.p[i]) - truth.Distance_m(points.p[i]);
      squares += error_m * error_m / kPoints;
    }
    const double expected_m =
        kSigma_m * std::sqrt(static_cast<double>(TypeParam::kParameterCount) / kPoints);
    EXPECT_LT(std::sqrt(squares), 3 * expected_m);
  }
}

TEST(ConeModel, AgreesWithTheSolidOnItsWall) {
  const Cone solid{.radius_bottom_m = 0.03, .radius_top_m = 0.05, .length_m = 0.1};
  const ConeModel model{.radius_m = 0.04, .slope = 0.2};
  RandomDraws draws(7, 0);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3 p = SurfacePointOf(model, draws) + 0.004 * RandomUnit(draws);
    EXPECT_NEAR(model.Distance_m(p), SignedDistance_m(solid, p), kRounding);
  }
}

TEST(CylinderModel, IsAConeOfSlopeZero) {
  RandomDraws draws(8, 0);
  const auto cylinder = RandomModel<CylinderModel>(draws);
  for (int trial = 0; trial < 100; ++trial) {
    const Vector3 p = RandomVector(draws, 0.3);
    EXPECT_NEAR(cylinder.Distance_m(p), cylinder.AsCone().Distance_m(p), kRounding);
  }
}

TEST(CylinderModel, ParallelNormalsDefineNone) {
  const SamplePoint sample[] = {{Vector3(0, 0, 0), Vector3::UnitX()},
                                {Vector3(0, 1, 0), Vector3::UnitX()}};
  EXPECT_FALSE(CylinderModel::FromSample(sample));
}

}  // namespace
}  // namespace cwm::perception
