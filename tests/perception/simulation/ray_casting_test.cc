#include "perception/simulation/ray_casting.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

// Rounding in roots of quadratics whose coefficients are of the order of 1 m.
constexpr double kRounding_m = 1e-9;

struct NamedShape {
  std::string name;
  Shape shape;
};

Plate PlateWithHole() {
  return {.outline = {{-0.4, -0.3}, {0.4, -0.3}, {0.4, 0.3}, {0.0, 0.1}, {-0.4, 0.3}},
          .holes = {{{-0.1, -0.2}, {0.1, -0.2}, {0.0, 0.0}}},
          .thickness_m = 0.05};
}

std::vector<NamedShape> AllShapes() {
  const TriangleMesh box = Tessellate(Box{.size_m = {0.4, 0.3, 0.2}}, 0.001);
  return {{"sphere", Sphere{.radius_m = 0.3}},
          {"box", Box{.size_m = {0.3, 0.4, 0.5}}},
          {"cylinder", Cylinder{.radius_m = 0.2, .length_m = 0.5}},
          {"cup", Cone{.radius_bottom_m = 0.1, .radius_top_m = 0.3, .length_m = 0.4}},
          {"apex", Cone{.radius_bottom_m = 0.3, .radius_top_m = 0, .length_m = 0.4}},
          {"capsule", Capsule{.radius_m = 0.15, .length_m = 0.4}},
          {"half_space", HalfSpace{}},
          {"plate", PlateWithHole()},
          {"convex", Convex{.hull = std::make_shared<TriangleMesh>(box)}},
          {"mesh", MakeMesh(box)}};
}

Vector3 RandomPoint(RandomDraws& draws, double extent_m) {
  const double x = draws.Uniform(-extent_m, extent_m);
  const double y = draws.Uniform(-extent_m, extent_m);
  return {x, y, draws.Uniform(-extent_m, extent_m)};
}

class RayCasting : public ::testing::TestWithParam<NamedShape> {};

TEST_P(RayCasting, HitsTheSurfaceWhereTheSignedDistanceFirstVanishes) {
  constexpr int kRays = 2000;
  constexpr int kSteps = 200;
  const Shape& shape = GetParam().shape;
  RandomDraws draws(1, 0);
  int hits = 0;
  for (int i = 0; i < kRays; ++i) {
    Ray ray{.origin = RandomPoint(draws, 1.0)};
    if (SignedDistance_m(shape, ray.origin) < 0.01) continue;
    const Vector3 target = RandomPoint(draws, 0.3);
    ray.direction = draws.Uniform(0.1, 2) * (target - ray.origin).normalized();
    const auto hit = CastRay(shape, ray);
    // Nothing solid lies before the hit, or within 3 m if there is no hit.
    const double end = hit ? hit->t : 3 / ray.direction.norm();
    for (int step = 0; step < kSteps; ++step) {
      const Vector3 p = ray.origin + end * step / kSteps * ray.direction;
      ASSERT_GT(SignedDistance_m(shape, p), -kRounding_m) << "ray " << i << " step " << step;
    }
    if (!hit) continue;
    ++hits;
    const SurfacePoint surface = NearestSurfacePoint(shape, ray.origin + hit->t * ray.direction);
    EXPECT_NEAR(surface.signed_distance_m, 0, kRounding_m);
    EXPECT_NEAR(hit->normal.norm(), 1, 1e-12);
    EXPECT_LE(hit->normal.dot(ray.direction), 0);
  }
  EXPECT_GT(hits, kRays / 20);
}

TEST_P(RayCasting, LeavesASolidWhereItsSurfaceIs) {
  constexpr int kRays = 500;
  const Shape& shape = GetParam().shape;
  RandomDraws draws(2, 0);
  for (int i = 0; i < kRays; ++i) {
    Ray ray{.origin = RandomPoint(draws, 0.5), .direction = RandomPoint(draws, 1).normalized()};
    if (SignedDistance_m(shape, ray.origin) > -0.01) continue;
    const auto hit = CastRay(shape, ray);
    if (GetParam().name == "half_space" && ray.direction.z() <= 0) {
      EXPECT_FALSE(hit);
      continue;
    }
    ASSERT_TRUE(hit) << "ray " << i;
    const Vector3 p = ray.origin + hit->t * ray.direction;
    EXPECT_NEAR(SignedDistance_m(shape, p), 0, kRounding_m);
    EXPECT_GT(SignedDistance_m(shape, p + 1e-6 * ray.direction), 0);
  }
}

INSTANTIATE_TEST_SUITE_P(AllShapes, RayCasting, ::testing::ValuesIn(AllShapes()),
                         [](const auto& info) { return info.param.name; });

TEST(RayCasting, GivesTheNormalOfTheFaceThatItMeets) {
  const Ray down{.origin = {0.05, 0.05, 2}, .direction = {0, 0, -1}};
  for (const Shape& shape :
       {Shape(Box{.size_m = {0.3, 0.4, 0.5}}), Shape(Cylinder{.radius_m = 0.2, .length_m = 0.5}),
        Shape(HalfSpace{})}) {
    const auto hit = CastRay(shape, down);
    ASSERT_TRUE(hit);
    EXPECT_NEAR((hit->normal - Vector3::UnitZ()).norm(), 0, 1e-12);
  }
  const auto side = CastRay(Cone{.radius_bottom_m = 0.1, .radius_top_m = 0.3, .length_m = 0.4},
                            {.origin = {2, 0, 0}, .direction = {-1, 0, 0}});
  ASSERT_TRUE(side);
  EXPECT_NEAR(side->t, 1.8, 1e-12);
  // The wall leans out by 0.2 over 0.4: its normal is (2, 0, -1) / sqrt 5.
  EXPECT_NEAR((side->normal - Vector3(2, 0, -1) / std::sqrt(5)).norm(), 0, 1e-12);
}

TEST(RayCasting, MissesBehindTheOrigin) {
  EXPECT_FALSE(CastRay(Sphere{.radius_m = 0.5}, {.origin = {0, 0, 1}, .direction = {0, 0, 1}}));
  EXPECT_FALSE(CastRay(HalfSpace{}, {.origin = {0, 0, 1}, .direction = {1, 0, 0}}));
}

TEST(RayCasting, PassesThroughTheHoleOfAPlate) {
  const Shape plate = PlateWithHole();
  EXPECT_FALSE(CastRay(plate, {.origin = {0, -0.15, 1}, .direction = {0, 0, -1}}));
  EXPECT_TRUE(CastRay(plate, {.origin = {0.3, -0.15, 1}, .direction = {0, 0, -1}}));
}

}  // namespace
}  // namespace cwm::perception
