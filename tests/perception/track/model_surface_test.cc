#include "perception/track/model_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "collision/geometry/tessellate.h"
#include "perception/simulation/random_draws.h"
#include "perception/track/alignment.h"

namespace cwm::perception {
namespace {

HybridModel ModelOf(Shape shape, const Pose& X_OS) {
  HybridModel model;
  model.shapes.push_back({.X_OS = X_OS, .shape = std::move(shape), .fit = {}});
  return model;
}

const Pose kPlace = MakePose({0.1, -0.2, 0.05}, Quaternion(0.9, 0.1, -0.3, 0.2).normalized());

TEST(ModelSurface, AgreesWithTheSignedDistanceOfTheShape) {
  const Shape shape = Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.05, .length_m = 0.1};
  const HybridModel model = ModelOf(shape, kPlace);
  const ModelSurface surface(model, 0.02);
  RandomDraws draws(1, 0);
  for (int i = 0; i < 500; ++i) {
    const Vector3 p{draws.Uniform(-0.3, 0.3), draws.Uniform(-0.3, 0.3), draws.Uniform(-0.3, 0.3)};
    const auto nearest = surface.Nearest(p);
    ASSERT_TRUE(nearest);
    EXPECT_NEAR(nearest->signed_distance_m, SignedDistance_m(shape, kPlace.inverse() * p), 1e-12);
  }
}

TEST(ModelSurface, FindsEveryTriangleWithinReachHoweverLarge) {
  constexpr double kReach_m = 0.02;
  TriangleMesh mesh = Tessellate(Sphere{.radius_m = 0.05}, 0.001);
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {{-1, -1, -0.1}, {2, -1, -0.12}, {-1, 2, -0.08}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  const Mesh placed = MakeMesh(mesh);
  HybridModel as_surface;
  as_surface.surfaces.push_back({.surface = placed, .point_count = 10});
  for (const HybridModel& model : {as_surface, ModelOf(placed, Pose::Identity())}) {
    const ModelSurface surface(model, kReach_m);
    RandomDraws draws(2, 0);
    for (int i = 0; i < 2000; ++i) {
      const Vector3 p{draws.Uniform(-0.2, 0.2), draws.Uniform(-0.2, 0.2), draws.Uniform(-0.2, 0.2)};
      const double distance_m = std::abs(SignedDistance_m(placed, p));
      const auto nearest = surface.Nearest(p);
      if (distance_m > kReach_m) continue;
      ASSERT_TRUE(nearest);
      EXPECT_NEAR(std::abs(nearest->signed_distance_m), distance_m, 1e-12);
    }
  }
}

TEST(ModelSurface, SamplesLieOnTheSurfaceEvenly) {
  const Shape shape = Box{.size_m = {0.1, 0.2, 0.3}};
  const HybridModel model = ModelOf(shape, kPlace);
  const auto samples = ModelSurface(model, 0.02).Samples(1000);
  EXPECT_NEAR(static_cast<double>(samples.size()), 1000, 100);
  int on_largest = 0;
  for (const SurfaceSample& sample : samples) {
    const SurfacePoint at = NearestSurfacePoint(shape, kPlace.inverse() * sample.p_O);
    EXPECT_NEAR(at.signed_distance_m, 0, 1e-12);
    EXPECT_NEAR(sample.normal_O.dot(kPlace.linear() * at.normal), 1, 1e-9);
    if (std::abs((kPlace.linear().transpose() * sample.normal_O).x()) > 0.9) ++on_largest;
  }
  // The faces across x have 0.12 of 0.22 square metres.
  EXPECT_NEAR(on_largest / static_cast<double>(samples.size()), 0.12 / 0.22, 0.03);
}

TEST(Align, FindsTheShiftAndTurnOfABoxFromThreeFaces) {
  const HybridModel model = ModelOf(Box{.size_m = {0.1, 0.16, 0.06}}, Pose::Identity());
  const ModelSurface surface(model, kAlignmentReach_m);
  const Pose X_LO = kPlace;
  std::vector<Eigen::Vector3f> points_L;
  for (const SurfaceSample& sample : surface.Samples(600)) {
    if (sample.normal_O.dot(Vector3(1, 1, 1)) > 0) {
      points_L.push_back((X_LO * sample.p_O).cast<float>());
    }
  }
  Pose guess = X_LO;
  guess.translation() += Vector3(0.008, -0.006, 0.005);
  guess.linear() = Eigen::AngleAxisd(0.08, Vector3(1, 2, 3).normalized()) * guess.linear();
  const Pose found = Align(points_L, surface, guess, 0.007);
  EXPECT_LT((found.translation() - X_LO.translation()).norm(), 1e-4);
  EXPECT_LT(RotationAngle_rad(found.linear(), X_LO.linear()), 1e-3);
}

TEST(Align, DoesNotSpinACan) {
  const HybridModel model =
      ModelOf(Cylinder{.radius_m = 0.035, .length_m = 0.12}, Pose::Identity());
  const ModelSurface surface(model, kAlignmentReach_m);
  std::vector<Eigen::Vector3f> points_L;
  for (const SurfaceSample& sample : surface.Samples(600)) {
    if (sample.normal_O.dot(Vector3(1, 0, 1)) <= 0) continue;
    // Samples lie on an inscribed mesh, up to half a millimetre inside.
    points_L.push_back(surface.Nearest(sample.p_O)->nearest.cast<float>());
  }
  const Pose guess = MakeTranslation(0.006, 0.004, -0.003);
  const Pose found = Align(points_L, surface, guess, 0.007);
  EXPECT_LT(found.translation().norm(), 1e-4);
  // The turn is not constrained. A part of the shift may be made by turning about the points'
  // centre, but no more than half of it over the radius.
  EXPECT_LT(RotationAngle_rad(found.linear(), Matrix3::Identity()),
            0.5 * guess.translation().norm() / 0.035);
}

}  // namespace
}  // namespace cwm::perception
