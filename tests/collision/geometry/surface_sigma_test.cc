#include "collision/geometry/surface_sigma.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "collision/geometry/coefficients.h"
#include "collision/geometry/signed_distance.h"

namespace cwm {
namespace {

constexpr double kRms_m = 0.004;

ShapePart Fitted(Shape shape, std::vector<double> sigma) {
  return {.X_OS = Pose::Identity(),
          .shape = std::move(shape),
          .fit = FitQuality{.rms_m = kRms_m, .parameter_sigma = std::move(sigma)}};
}

TEST(SurfaceSigma, IsTheSumOfWhatMovesTheSurface) {
  EXPECT_DOUBLE_EQ(SurfaceSigma_m(Fitted(Sphere{0.1}, {0.003, 0.004, 0, 0.001})), 0.006);
  // The rim is 0.05 m from the centre.
  EXPECT_DOUBLE_EQ(SurfaceSigma_m(Fitted(Cylinder{0.03, 0.08}, {0, 0, 0.002, 0.1, 0, 0, 0.001})),
                   0.002 + 0.05 * 0.1 + 0.001);
  // The apex is half the length below the cone; the slant to the wider rim is 0.05 m.
  EXPECT_DOUBLE_EQ(SurfaceSigma_m(Fitted(Cone{0.015, 0.03, 0.02}, {0, 0.002, 0, 0, 0.1, 0, 0.02})),
                   0.002 + 0.05 * (0.1 + 0.02));
  // An error of the apex along the axis moves the surface by the sine of the half angle, 0.6, times
  // it.
  EXPECT_NEAR(SurfaceSigma_m(Fitted(Cone{0.015, 0.03, 0.02}, {0, 0, 0.04, 0, 0, 0, 0})), 0.6 * 0.04,
              1e-12);
  EXPECT_DOUBLE_EQ(SurfaceSigma_m(Fitted(
                       Plate{.outline = {{0, 0}, {3, 0}, {3, 4}}, .holes = {}, .thickness_m = 0.02},
                       {0.001, 0, 0, 0.002})),
                   0.002 + 5 * 0.001);
  EXPECT_DOUBLE_EQ(SurfaceSigma_m(Fitted(Box{{1, 1, 1}}, {0.002, 0.003, 0.006})), 0.007);
}

TEST(SurfaceSigma, IsTheScatterWhereTheDeviationsAreUnknownAndNothingWithoutAFit) {
  EXPECT_EQ(SurfaceSigma_m(Fitted(Sphere{0.1}, {})), kRms_m);
  EXPECT_EQ(SurfaceSigma_m(Fitted(Sphere{0.1}, {1, 1, 1})), kRms_m);  // not of a sphere
  EXPECT_EQ(SurfaceSigma_m(Fitted(Capsule{0.1, 0.1}, {1, 1, 1})), kRms_m);
  EXPECT_EQ(SurfaceSigma_m(Fitted(Cone{0.1, 0.1, 1}, {1, 1, 1, 1, 1, 1, 1})), kRms_m);
  EXPECT_EQ(SurfaceSigma_m({.X_OS = Pose::Identity(), .shape = Sphere{0.1}}), 0);
}

// Finds the rim of a cone from its apex, axis and angle, and compares its deviation with the bound.
TEST(SurfaceSigma, BoundsWhatRandomDeviationsDoToARim) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const Cone cone{0.015, 0.03, 0.02};
  const std::vector<double> sigma = {0.001, 0.0005, 0.002, 0.02, 0.01, 0, 0.03};
  const std::vector<double> c = Coefficients(cone, Pose::Identity());
  const auto rim = [&](const std::vector<double>& at) {
    const Vector3 apex(at[0], at[1], at[2]);
    const Vector3 axis = Vector3(at[3], at[4], at[5]).normalized();
    const Vector3 across = axis.cross(Vector3::UnitY()).normalized();
    return Vector3(apex + 0.05 * (std::cos(at[6]) * axis + std::sin(at[6]) * across));
  };
  double squares = 0;
  constexpr int kCount = 20'000;
  for (int i = 0; i < kCount; ++i) {
    std::vector<double> moved = c;
    for (std::size_t k = 0; k < c.size(); ++k) moved[k] += sigma[k] * normal(random);
    squares += (rim(moved) - rim(c)).squaredNorm();
  }
  const double deviation_m = std::sqrt(squares / kCount);
  const double said_m = SurfaceSigma_m(Fitted(cone, sigma));
  EXPECT_LE(deviation_m, said_m);
  EXPECT_GE(deviation_m, 0.4 * said_m);  // for these sigmas every term counts, added in quadrature
}

}  // namespace
}  // namespace cwm
