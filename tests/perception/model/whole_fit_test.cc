// Closed solids fitted to all points of an object at once.
#include "perception/model/whole_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "collision/geometry/signed_distance.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

const Vector3 kEye(-0.6, -0.3, 0.7);
constexpr double kFoot_m = 0.006;   // is lost in the band of the support
constexpr double kExact_m = 0.001;  // of exact points: the descent ends well within their sigma
constexpr double kFarAway = 1e3;    // the loss of a rival that every start beats
constexpr double kSigma_m = 0.0015;

// What the eye sees of a solid on z = 0: random points moved to the nearest of the surface, whose
// normals say nothing.
OrientedPoints SeenOf(WholeKind kind, const WholeParameters& x, double noise_m) {
  const WholeSolid solid = Place(kind, x);
  RandomDraws random(1, 0);
  OrientedPoints points;
  points.viewpoint = kEye;
  while (points.size() < 900) {
    const Vector3 p_S(random.Uniform(-0.15, 0.15), random.Uniform(-0.15, 0.15),
                      random.Uniform(-0.15, 0.15));
    const SurfacePoint nearest = NearestSurfacePoint(solid.shape, p_S);
    const Vector3 p = solid.X_GS * nearest.nearest;
    const Vector3 n = solid.X_GS.linear() * nearest.normal;
    if (n.dot(kEye - p) < 0.1 || p.z() < kFoot_m) continue;
    const Vector3 ray = (p - kEye).normalized();
    points.points.push_back((p + noise_m * random.Normal() * ray).cast<float>());
    points.normals.push_back(Eigen::Vector3f::UnitZ());
    points.sigma_m.push_back(static_cast<float>(kSigma_m));
    points.normal_sigma_rad.push_back(0.05f);
    points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
  }
  return points;
}

struct Fixture {
  explicit Fixture(const OrientedPoints& seen)
      : points(ThinForSearch(seen, 4000)), octree(points), connectivity(points) {}
  FitContext Context() const {
    return {points,
            octree,
            connectivity,
            noise,
            options,
            work,
            Ground{.known = true, .up = Vector3::UnitZ(), .point = -points.origin_L}};
  }

  ModelPoints points;
  Octree octree;
  Connectivity connectivity;
  SensorNoise noise;
  ModelerOptions options;
  Work work;
};

struct Case {
  const char* name;
  WholeKind kind;
  std::vector<double> x;
};

WholeParameters ParametersOf(const Case& c) {
  return Eigen::Map<const Eigen::VectorXd>(c.x.data(), static_cast<Eigen::Index>(c.x.size()));
}

double FarthestFrom_m(const Solid& solid, const ModelPoints& points) {
  double farthest_m = 0;
  for (const Vector3& p : points.p) {
    farthest_m =
        std::max(farthest_m, std::abs(SignedDistance_m(solid.shape, solid.X_MS.inverse() * p)));
  }
  return farthest_m;
}

// Which parameters are sizes, that no choice of a frame changes.
std::vector<Eigen::Index> SizesOf(WholeKind kind) {
  switch (kind) {
    case WholeKind::kBall:
      return {3};
    case WholeKind::kUprightCylinder:
      return {2, 3};
    case WholeKind::kUprightCone:
      return {2, 3, 4};
    case WholeKind::kLyingCylinder:
      return {3, 4};
    case WholeKind::kLyingCone:
      return {3, 4, 5};
    case WholeKind::kUprightBox:  // width and depth may change places
      return {5};
    case WholeKind::kTiltedBox:
      return {};
  }
  return {};
}

class FitWholeTest : public testing::TestWithParam<Case> {};

TEST_P(FitWholeTest, FindsTheSolidThroughExactPointsWhateverTheirNormalsSay) {
  const WholeParameters truth = ParametersOf(GetParam());
  const Fixture f(SeenOf(GetParam().kind, truth, 0));
  const auto fit = FitWhole(GetParam().kind, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(FarthestFrom_m(fit->solid, f.points), kExact_m);
  EXPECT_EQ(fit->solid.inliers.size(), f.points.size());
  EXPECT_NEAR(SlopeOf(fit->kind, fit->parameters), SlopeOf(GetParam().kind, truth), 0.01);
}

TEST_P(FitWholeTest, ErrsByAboutItsStandardDeviations) {
  const WholeParameters truth = ParametersOf(GetParam());
  const Fixture f(SeenOf(GetParam().kind, truth, kSigma_m));
  const auto fit = FitWhole(GetParam().kind, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  const Eigen::MatrixXd covariance = CovarianceOf(*fit, f.Context());
  for (Eigen::Index k : SizesOf(GetParam().kind)) {
    const double sigma = std::sqrt(covariance(k, k));
    EXPECT_GT(sigma, 0) << k;
    EXPECT_NEAR(std::abs(fit->parameters(k)), std::abs(truth(k)), 4 * sigma) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, FitWholeTest,
    testing::Values(Case{"Ball", WholeKind::kBall, {0.01, 0.02, 0.03, 0.03}},
                    Case{"UprightCylinder", WholeKind::kUprightCylinder, {0.01, 0.02, 0.1, 0.015}},
                    Case{"UprightCone", WholeKind::kUprightCone, {0.01, 0.02, 0.1, 0.045, 0.15}},
                    Case{"LyingCylinder", WholeKind::kLyingCylinder, {0.01, 0.02, 0.4, 0.02, 0.1}},
                    Case{"LyingCone", WholeKind::kLyingCone, {0.01, 0.02, 0.4, 0.03, 0.1, 0.12}},
                    Case{"UprightBox", WholeKind::kUprightBox, {0.01, 0.02, 0.4, 0.06, 0.1, 0.05}}),
    [](const testing::TestParamInfo<Case>& info) { return info.param.name; });

TEST(FitWhole, StartsATiltedBoxFromOneThatIsKnown) {
  WholeParameters truth(9);
  truth << 0.01, 0.02, 0.08, 0.3, 0.4, 0.2, 0.06, 0.1, 0.05;
  const Fixture f(SeenOf(WholeKind::kTiltedBox, truth, 0));
  EXPECT_FALSE(FitWhole(WholeKind::kTiltedBox, {}, kFarAway, f.Context()).has_value());
  WholeParameters near = truth;
  near.array() += 0.01;
  const WholeSolid known = Place(WholeKind::kTiltedBox, near);
  Solid solid;
  solid.X_MS = Eigen::Translation3d(-f.points.origin_L) * known.X_GS;
  solid.shape = known.shape;
  const auto fit = FitWhole(WholeKind::kTiltedBox, {solid}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(FarthestFrom_m(fit->solid, f.points), kExact_m);
}

TEST(FitWhole, GivesUpWhereEveryStartIsFarWorseThanItsRival) {
  WholeParameters box(6);
  box << 0.01, 0.02, 0.4, 0.06, 0.1, 0.05;
  const Fixture f(SeenOf(WholeKind::kUprightBox, box, kSigma_m));
  const auto fit = FitWhole(WholeKind::kUprightBox, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  const Account account = AccountOf({fit->solid}, 6, f.Context());
  EXPECT_NEAR(account.value, fit->value, 1e-6 * fit->value);
  EXPECT_FALSE(FitWhole(WholeKind::kBall, {}, account.loss, f.Context()).has_value());
}

TEST(FitWhole, AsksForAGround) {
  const Fixture f(SeenOf(WholeKind::kBall, Eigen::Vector4d(0, 0, 0.03, 0.03), 0));
  FitContext context = f.Context();
  context.ground.known = false;
  EXPECT_FALSE(FitWhole(WholeKind::kBall, {}, kFarAway, context).has_value());
}

// The parameters of a kind make a solid, and the solid its parameters.
TEST(WholeKind, ParametersSurviveTheSolid) {
  for (const Case& c :
       {Case{"", WholeKind::kUprightCone, {0.01, 0.02, 0.1, 0.045, 0.15}},
        Case{"", WholeKind::kLyingCone, {0.01, 0.02, 0.4, 0.03, 0.1, 0.12}},
        Case{"", WholeKind::kUprightCylinder, {0.01, 0.02, 0.1, 0.015}},
        Case{"", WholeKind::kLyingCylinder, {0.01, 0.02, 0.4, 0.02, 0.1}},
        Case{"", WholeKind::kTiltedBox, {0.01, 0.02, 0.08, 0.3, 0.4, 0.2, 0.06, 0.1, 0.05}}}) {
    const WholeParameters x = ParametersOf(c);
    const auto back = perception::ParametersOf(c.kind, Place(c.kind, x));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - x).cwiseAbs().maxCoeff(), 1e-12) << static_cast<int>(c.kind);
  }
}

TEST(WholeKind, WhatLiesTouchesTheGroundAlongALine) {
  WholeParameters x(6);
  x << 0.01, 0.02, 0.4, 0.03, 0.1, 0.12;
  const WholeSolid cup = Place(WholeKind::kLyingCone, x);
  const auto& cone = std::get<Cone>(cup.shape);
  const Vector3 down_S = cup.X_GS.linear().transpose() * -Vector3::UnitZ();
  const Vector3 across = Vector3(down_S.x(), down_S.y(), 0).normalized();
  const Vector3 bottom = cone.radius_bottom_m * across - 0.5 * cone.length_m * Vector3::UnitZ();
  const Vector3 top = cone.radius_top_m * across + 0.5 * cone.length_m * Vector3::UnitZ();
  EXPECT_NEAR((cup.X_GS * bottom).z(), 0, 1e-12);
  EXPECT_NEAR((cup.X_GS * top).z(), 0, 1e-12);
}

}  // namespace
}  // namespace cwm::perception
