#include "perception/primitive_fit/solid_lanes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

constexpr double kRounding = 1e-12;  // relative to the coordinates

Vector3 AnyPoint(RandomDraws& draws, double reach_m) {
  return {draws.Uniform(-reach_m, reach_m), draws.Uniform(-reach_m, reach_m),
          draws.Uniform(-reach_m, reach_m)};
}

Pose AnyPose(RandomDraws& draws) {
  Pose pose = Pose::Identity();
  const Vector3 axis = (AnyPoint(draws, 1) + Vector3(0, 0, 1e-3)).normalized();
  pose.linear() = Eigen::AngleAxisd(draws.Uniform(-3, 3), axis).toRotationMatrix();
  pose.translation() = AnyPoint(draws, 2);
  return pose;
}

std::vector<Shape> Solids() {
  return {Sphere{0.1},          Box{{0.1, 0.2, 0.3}}, Cylinder{0.05, 0.2},
          Cone{0.1, 0.05, 0.2}, Cone{0.1, 0.0, 0.2},  Cone{0.0, 0.1, 0.2},
          Box{{0.4, 1e-3, 1}},  Cylinder{0.2, 1e-3},  Cone{0.02, 0.3, 0.01}};
}

void ExpectSame(const Shape& solid, const std::vector<Vector3>& places, const Pose& X_SP) {
  std::vector<double> told_m(places.size(), -7);
  PlaceLanes(places).DistancesTo(solid, X_SP, told_m);
  for (std::size_t i = 0; i < places.size(); ++i) {
    ASSERT_NEAR(told_m[i], SignedDistance_m(solid, X_SP * places[i]), 4 * kRounding)
        << NameOf(KindOf(solid)) << " at " << (X_SP * places[i]).transpose();
  }
}

TEST(PlaceLanes, TellsTheSignedDistance) {
  RandomDraws draws(3, 0);
  for (const Shape& solid : Solids()) {
    for (const double reach_m : {0.01, 0.15, 3.0}) {
      const Pose X_SP = AnyPose(draws);
      const Pose X_PS = X_SP.inverse(Eigen::Isometry);
      std::vector<Vector3> places;
      for (int i = 0; i < 400; ++i) places.emplace_back(X_PS * AnyPoint(draws, reach_m));
      ExpectSame(solid, places, X_SP);
    }
  }
}

TEST(PlaceLanes, TellsItOnTheAxisAndAtTheMiddle) {
  const std::vector<Vector3> places = {{0, 0, 0}, {0, 0, 0.04}, {0, 0, 0.3}, {0, 0, -0.3}};
  for (const Shape& solid : Solids()) ExpectSame(solid, places, Pose::Identity());
}

TEST(PlaceLanes, TakesAnyNumberOfPlaces) {
  for (std::size_t count = 0; count < 10; ++count) {
    std::vector<Vector3> places;
    for (std::size_t i = 0; i < count; ++i)
      places.emplace_back(0.03 * static_cast<double>(i), 0, 0);
    ExpectSame(Sphere{0.1}, places, Pose::Identity());
  }
}

}  // namespace
}  // namespace cwm::perception
