// The rim of a disc, and how it corrects the wall below it.
#include "perception/fit/rim.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "perception/simulation/random_draws.h"
#include "tests/perception/fit/fit_input.h"

namespace cwm::perception {
namespace {

constexpr double kRange_m = 0.8;       // from the sensor to the face, which it sees from 45 degrees
constexpr double kPixel_m = 0.0015;    // of a Kinect there
constexpr double kLateral_m = 0.0012;  // noise across the ray there
constexpr double kRadius_m = 0.04;
// The edge of the circle is 160 pixels long, half of which is used; each errs by the noise across
// the ray.
constexpr double kRadiusSigma_m = kLateral_m / 8.9442719;  // sqrt(80)

const Vector3 kViewpoint = kRange_m / std::numbers::sqrt2 * Vector3(-1, 0, 1);

// A level face at z = 0 as the pixels of a sensor see it: the points of a grid that is stretched
// along the view, moved by noise across the ray; those inside the outline are kept.
template <class Inside>
OrientedPoints Face(const Inside& inside, std::uint64_t seed) {
  OrientedPoints points;
  points.viewpoint = kViewpoint;
  RandomDraws draws(seed, 0);
  for (double x = -0.08; x < 0.08; x += kPixel_m * std::numbers::sqrt2) {
    for (double y = -0.08; y < 0.08; y += kPixel_m) {
      if (!inside(Vector2(x, y))) continue;
      const Vector2 moved{x + kLateral_m * draws.Normal(), y + kLateral_m * draws.Normal()};
      points.points.push_back(Vector3(moved.x(), moved.y(), 0).cast<float>());
      points.normals.push_back(Eigen::Vector3f::UnitZ());
      points.sigma_m.push_back(0.0015f);
      points.normal_sigma_rad.push_back(0.05f);
      points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
    }
  }
  return points;
}

bool InDisc(const Vector2& p) { return p.norm() < kRadius_m; }

// The input of a fit, made of these points.
struct Fixture : FitInput {
  explicit Fixture(const OrientedPoints& face) : FitInput(SubsampleForSearch(face, face.size())) {}

  PlaneModel Level() const { return {.point = Local(Vector3::Zero()), .normal = Vector3::UnitZ()}; }
  // A wall below the face whose axis and radius are inaccurate.
  ConeModel BadWall() const {
    return {.point = Local(Vector3(0.002, -0.001, -0.05)),
            .axis = Vector3::UnitZ(),
            .radius_m = kRadius_m - 0.003};
  }
};

constexpr double kWallSigma_m = 0.002;

TEST(Rim, TellsRadiusAndCentreOfADiscFromItsFarEdge) {
  double squares = 0;
  constexpr int kScans = 20;
  for (std::uint64_t seed = 0; seed < kScans; ++seed) {
    const Fixture fixture(Face(InDisc, seed));
    const auto rim =
        MeasureRim(fixture.Level(), fixture.BadWall(), kWallSigma_m, fixture.Context());
    ASSERT_TRUE(rim) << "seed " << seed;
    // Half of the edge is used, so centre and radius are less certain along the view: 3 times.
    EXPECT_NEAR(rim->radius_m, kRadius_m, 3 * 3 * kRadiusSigma_m) << "seed " << seed;
    const Vector2 off =
        (rim->basis.transpose() * (rim->center - fixture.Local(Vector3::Zero()))).head<2>();
    const Vector3 error(off.x(), off.y(), rim->radius_m - kRadius_m);
    squares += error.dot(rim->covariance.inverse() * error);
    EXPECT_LT(std::sqrt(rim->covariance(0, 0)), kWallSigma_m) << "no news to its wall";
  }
  // In units of the reported variances the mean of three values is 3; over 20 scans it deviates by
  // 0.55.
  EXPECT_LT(squares / kScans, 3 + 3 * 0.55);
}

TEST(Rim, OfASquareIsNone) {
  const Fixture fixture(
      Face([](const Vector2& p) { return p.cwiseAbs().maxCoeff() < kRadius_m; }, 1));
  ConeModel wall = fixture.BadWall();
  wall.radius_m = 1.12 * kRadius_m;  // the circle nearest to the square
  EXPECT_FALSE(MeasureRim(fixture.Level(), wall, kWallSigma_m, fixture.Context()));
}

TEST(Rim, IsNotLookedForWhereTheWallShows) {
  OrientedPoints face = Face(InDisc, 1);
  face.viewpoint = Vector3(0, 0, kRange_m);
  const Fixture from_above(face);
  ConeModel wall = from_above.BadWall();
  EXPECT_TRUE(MeasureRim(from_above.Level(), wall, kWallSigma_m, from_above.Context()));
  wall.slope = -2;  // wider below: its normals point up, towards the sensor
  wall.radius_m += 2 * 0.05;
  EXPECT_FALSE(MeasureRim(from_above.Level(), wall, kWallSigma_m, from_above.Context()));
}

TEST(Rim, CorrectsItsWallByWhatEachIsSureOf) {
  const Fixture fixture(Face(InDisc, 3));
  const ConeModel cone = fixture.BadWall();
  const CylinderModel wall{.point = cone.point, .axis = cone.axis, .radius_m = cone.radius_m};
  const auto rim = MeasureRim(fixture.Level(), cone, kWallSigma_m, fixture.Context());
  ASSERT_TRUE(rim);
  Eigen::MatrixXd covariance = 0.003 * 0.003 * Eigen::MatrixXd::Identity(5, 5);
  const Eigen::MatrixXd before = covariance;
  const CylinderModel fused = FuseRim(wall, *rim, covariance);
  EXPECT_NEAR(fused.radius_m, kRadius_m, 3 * 3 * kRadiusSigma_m);
  EXPECT_LT(covariance(4, 4), before(4, 4) / 4);
  // A wall with a small covariance that lies elsewhere is not changed by the rim.
  Eigen::MatrixXd sure = 1e-10 * Eigen::MatrixXd::Identity(5, 5);
  EXPECT_EQ(FuseRim(wall, *rim, sure).radius_m, wall.radius_m);
}

}  // namespace
}  // namespace cwm::perception
