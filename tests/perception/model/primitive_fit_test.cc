// Closed solids fitted to all points of an object at once.
#include "perception/primitive_fit/primitive_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "collision/geometry/signed_distance.h"
#include "perception/primitive_fit/primitive_fit_misfit.h"
#include "perception/primitive_fit/single_primitive.h"
#include "perception/simulation/random_draws.h"
#include "perception/solids/free_space.h"
#include "tests/perception/fit/fit_input.h"

namespace cwm::perception {
namespace {

const Vector3 kEye(-0.6, -0.3, 0.7);
constexpr double kFoot_m = 0.006;   // hidden in the band of the support
constexpr double kExact_m = 0.001;  // for exact points: the descent ends well within their sigma
constexpr FitScore kFarAway{.value = 1e6, .loss = 1e3};  // an alternative that every start beats
constexpr double kSigma_m = 0.0015;

// The points that the eye sees of a solid on z = 0: random points moved to the nearest surface,
// with normals that carry no information.
OrientedPoints SeenOf(PrimitiveKind kind, const PrimitiveParameters& x, double noise_m,
                      std::uint64_t seed = 1) {
  const PlacedPrimitive solid = Place(kind, x);
  RandomDraws random(seed, 0);
  OrientedPoints points;
  points.viewpoint = kEye;
  while (points.size() < 900) {
    const double z = random.Uniform(-0.15, 0.15), y = random.Uniform(-0.15, 0.15);
    const Vector3 p_S(random.Uniform(-0.15, 0.15), y, z);
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

struct Fixture : FitInput {
  explicit Fixture(const OrientedPoints& seen) : FitInput(SubsampleForSearch(seen, 4000)) {}
  FitContext Context() const {
    return FitInput::Context(
        Ground{.known = true, .up = Vector3::UnitZ(), .point = -points.origin_L});
  }
};

struct Case {
  const char* name;
  PrimitiveKind kind;
  std::vector<double> x;
};

PrimitiveParameters ParametersOf(const Case& c) {
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

// The indices of the parameters that are sizes, which no choice of a frame changes.
std::vector<Eigen::Index> SizesOf(PrimitiveKind kind) {
  switch (kind) {
    case PrimitiveKind::kBall:
      return {3};
    case PrimitiveKind::kUprightCylinder:
      return {2, 3};
    case PrimitiveKind::kUprightCone:
      return {2, 3, 4};
    case PrimitiveKind::kLyingCylinder:
      return {3, 4};
    case PrimitiveKind::kLyingCone:
      return {3, 4, 5};
    case PrimitiveKind::kLeaningCylinder:
      return {4, 5};
    case PrimitiveKind::kUprightBox:  // width and depth may be swapped
      return {5};
    case PrimitiveKind::kTiltedBox:
      return {};
  }
  return {};
}

class PrimitiveFitTest : public ::testing::TestWithParam<Case> {};

TEST_P(PrimitiveFitTest, FindsTheSolidThroughExactPointsWhateverTheirNormalsSay) {
  const PrimitiveParameters truth = ParametersOf(GetParam());
  const Fixture f(SeenOf(GetParam().kind, truth, 0));
  const auto fit = FitPrimitive(GetParam().kind, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(FarthestFrom_m(fit->solid, f.points), kExact_m);
  EXPECT_EQ(fit->solid.inliers.size(), f.points.size());
  EXPECT_NEAR(SlopeOf(fit->kind, fit->parameters), SlopeOf(GetParam().kind, truth), 0.01);
}

TEST_P(PrimitiveFitTest, ErrsByAboutItsStandardDeviations) {
  const PrimitiveParameters truth = ParametersOf(GetParam());
  const Fixture f(SeenOf(GetParam().kind, truth, kSigma_m));
  const auto fit = FitPrimitive(GetParam().kind, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  const Eigen::MatrixXd covariance = CovarianceOf(*fit, f.Context());
  for (Eigen::Index k : SizesOf(GetParam().kind)) {
    const double sigma = std::sqrt(covariance(k, k));
    EXPECT_GT(sigma, 0) << k;
    EXPECT_NEAR(std::abs(fit->parameters(k)), std::abs(truth(k)), 4 * sigma) << k;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, PrimitiveFitTest,
    ::testing::Values(
        Case{"Ball", PrimitiveKind::kBall, {0.01, 0.02, 0.03, 0.03}},
        Case{"UprightCylinder", PrimitiveKind::kUprightCylinder, {0.01, 0.02, 0.1, 0.015}},
        Case{"UprightCone", PrimitiveKind::kUprightCone, {0.01, 0.02, 0.1, 0.045, 0.15}},
        Case{"LyingCylinder", PrimitiveKind::kLyingCylinder, {0.01, 0.02, 0.4, 0.02, 0.1}},
        Case{"LyingCone", PrimitiveKind::kLyingCone, {0.01, 0.02, 0.4, 0.03, 0.1, 0.12}},
        Case{
            "LeaningCylinder", PrimitiveKind::kLeaningCylinder, {0.01, 0.02, 0.4, 0.9, 0.02, 0.12}},
        Case{"UprightBox", PrimitiveKind::kUprightBox, {0.01, 0.02, 0.4, 0.06, 0.1, 0.05}}),
    [](const ::testing::TestParamInfo<Case>& info) { return info.param.name; });

TEST(FitPrimitive, StartsATiltedBoxFromOneThatIsKnown) {
  PrimitiveParameters truth(9);
  truth << 0.01, 0.02, 0.08, 0.3, 0.4, 0.2, 0.06, 0.1, 0.05;
  const Fixture f(SeenOf(PrimitiveKind::kTiltedBox, truth, 0));
  EXPECT_FALSE(FitPrimitive(PrimitiveKind::kTiltedBox, {}, kFarAway, f.Context()).has_value());
  PrimitiveParameters near = truth;
  near.array() += 0.01;
  const PlacedPrimitive known = Place(PrimitiveKind::kTiltedBox, near);
  Solid solid;
  solid.X_MS = Eigen::Translation3d(-f.points.origin_L) * known.X_GS;
  solid.shape = known.shape;
  const auto fit = FitPrimitive(PrimitiveKind::kTiltedBox, {solid}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(FarthestFrom_m(fit->solid, f.points), kExact_m);
}

TEST(FitPrimitive, GivesUpWhereEveryStartIsFarWorseThanItsRival) {
  PrimitiveParameters box(6);
  box << 0.01, 0.02, 0.4, 0.06, 0.1, 0.05;
  const Fixture f(SeenOf(PrimitiveKind::kUprightBox, box, kSigma_m));
  const auto fit = FitPrimitive(PrimitiveKind::kUprightBox, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  const FitScore account = FitScoreOf({fit->solid}, 6, f.Context());
  EXPECT_NEAR(account.value, fit->value, 1e-6 * fit->value);
  EXPECT_FALSE(FitPrimitive(PrimitiveKind::kBall, {}, account, f.Context()).has_value());
}

// The far half of the box is hidden: no point constrains the end that was not seen.
TEST(FitPrimitive, EndsABoxWhereItsPointsEnd) {
  PrimitiveParameters box(6);
  box << 0, 0, 0, 0.2, 0.06, 0.05;
  OrientedPoints seen = SeenOf(PrimitiveKind::kUprightBox, box, kSigma_m);
  constexpr float kHiddenBeyond_m = 0.03f;
  OrientedPoints half;
  half.viewpoint = seen.viewpoint;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (seen.points[i].x() > kHiddenBeyond_m) continue;
    half.points.push_back(seen.points[i]);
    half.normals.push_back(seen.normals[i]);
    half.sigma_m.push_back(seen.sigma_m[i]);
    half.normal_sigma_rad.push_back(seen.normal_sigma_rad[i]);
    half.cloud_index.push_back(static_cast<std::uint32_t>(half.cloud_index.size()));
  }
  const Fixture f(half);
  const auto fit = FitPrimitive(PrimitiveKind::kUprightBox, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(std::get<Box>(fit->solid.shape).size_m.maxCoeff(), 0.13, 4 * kSigma_m);
}

// A box needs twice the minimum radius as its thickness: a sheet is no box, since a box of that
// thickness would stand for it.
TEST(FitPrimitive, MakesNoBoxOfASheet) {
  PrimitiveParameters sheet(6);
  sheet << 0, 0, 0.7, 0.16, 0.003, 0.12;
  const Fixture thin(SeenOf(PrimitiveKind::kUprightBox, sheet, 0));
  EXPECT_FALSE(FitPrimitive(PrimitiveKind::kUprightBox, {}, kFarAway, thin.Context()).has_value());
  sheet(4) = 0.02;
  const Fixture thick(SeenOf(PrimitiveKind::kUprightBox, sheet, 0));
  EXPECT_TRUE(FitPrimitive(PrimitiveKind::kUprightBox, {}, kFarAway, thick.Context()).has_value());
}

// A beaker that narrows to a foot of 4 mm would tip over; no cone with so slim a foot is proposed.
TEST(FitPrimitive, StandsNoConeOnItsTip) {
  PrimitiveParameters cone(5);
  cone << 0, 0, 0.12, 0.04, 0.3;
  const Fixture tip(SeenOf(PrimitiveKind::kUprightCone, cone, 0));
  EXPECT_FALSE(FitPrimitive(PrimitiveKind::kUprightCone, {}, kFarAway, tip.Context()).has_value());
  cone(4) = 0.2;  // a foot of 16 mm
  const Fixture cup(SeenOf(PrimitiveKind::kUprightCone, cone, 0));
  const auto stands = FitPrimitive(PrimitiveKind::kUprightCone, {}, kFarAway, cup.Context());
  ASSERT_TRUE(stands.has_value());
  EXPECT_NEAR(std::get<Cone>(stands->solid.shape).radius_bottom_m, 0.016, 1e-4);
}

// Four times as many points, whose noise is independent here, halve the error.
TEST(RefineOnMorePoints, KnowsAnAxisBetter) {
  constexpr int kSeeds = 20;
  constexpr Eigen::Index kYaw = 2;
  const PrimitiveParameters truth =
      (PrimitiveParameters(5) << 0.01, 0.02, 0.4, 0.03, 0.06).finished();
  double before = 0, after = 0;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    const Fixture f(SeenOf(PrimitiveKind::kLyingCylinder, truth, kSigma_m, seed));
    auto fit = FitPrimitive(PrimitiveKind::kLyingCylinder, {}, kFarAway, f.Context());
    ASSERT_TRUE(fit.has_value());
    const auto square = [&] {
      return std::pow(std::remainder(fit->parameters(kYaw) - truth(kYaw), std::numbers::pi), 2);
    };
    before += square();
    RefineOnMorePoints(f.Context(), *fit);
    after += square();
    EXPECT_GE(fit->solid.inliers.size(), f.points.size() * 95 / 100);
  }
  EXPECT_LT(std::sqrt(after), 0.75 * std::sqrt(before));
}

TEST(RefineOnMorePoints, LeavesAFitToAllPointsAlone) {
  const PrimitiveParameters truth =
      (PrimitiveParameters(5) << 0.01, 0.02, 0.4, 0.03, 0.06).finished();
  OrientedPoints few = SeenOf(PrimitiveKind::kLyingCylinder, truth, kSigma_m);
  std::vector<std::uint32_t> first(200);
  std::iota(first.begin(), first.end(), 0u);
  const Fixture f(Subset(few, first));
  auto fit = FitPrimitive(PrimitiveKind::kLyingCylinder, {}, kFarAway, f.Context());
  ASSERT_TRUE(fit.has_value());
  const PrimitiveParameters before = fit->parameters;
  RefineOnMorePoints(f.Context(), *fit);
  EXPECT_EQ(fit->parameters, before);
}

// A ray straight down moves a point off the top by the noise of the range alone; at grazing
// incidence it moves it off by the lateral noise.
TEST(SetNoiseAcrossSurface, TurnsFromTheNoiseOfTheRangeToTheLateralOne) {
  const PlacedPrimitive table{.X_GS = Pose::Identity(), .shape = Box{.size_m = {2, 2, 0.02}}};
  const SensorNoise noise;
  constexpr double kSlant_rad = std::numbers::pi / 3, kRange_m = 0.8;
  PointsOnGround points;
  points.viewpoint_G = Vector3(0, 0, 0.01 + kRange_m * std::cos(kSlant_rad));
  points.p_G = {Vector3(0, 0, 0.01), Vector3(kRange_m * std::sin(kSlant_rad), 0, 0.01)};
  points.sigma_m = {kSigma_m, kSigma_m};
  SetNoiseAcrossSurface(table, noise, points);
  constexpr double kRounding_m = 1e-6;
  EXPECT_NEAR(points.sigma_m[0], kSigma_m, kRounding_m);
  EXPECT_NEAR(
      points.sigma_m[1],
      std::hypot(0.5 * kSigma_m, std::sin(kSlant_rad) * noise.LateralSigma_m(kRange_m, kSlant_rad)),
      kRounding_m);
}

TEST(FitPrimitive, AsksForAGround) {
  const Fixture f(SeenOf(PrimitiveKind::kBall, Eigen::Vector4d(0, 0, 0.03, 0.03), 0));
  FitContext context = f.Context();
  context.ground.known = false;
  EXPECT_FALSE(FitPrimitive(PrimitiveKind::kBall, {}, kFarAway, context).has_value());
}

// Only the round top of a cup is visible; the rays beside it meet the ground.
struct RoundTop {
  static constexpr double kRadius_m = 0.05, kHeight_m = 0.1, kSlope = 0.25;

  // Rays to the ground around the foot of the cup, some of which end within the foot of a can.
  static PassingRays RaysBesideTheCup() {
    PassingRays rays;
    rays.weight = 20;
    const double foot_m = kRadius_m - kSlope * kHeight_m + 0.005;
    for (double away_m = foot_m; away_m < 0.12; away_m += 0.005) {
      for (double angle_rad = 0; angle_rad < 6.28; angle_rad += 0.2) {
        const Vector3 end(away_m * std::cos(angle_rad), away_m * std::sin(angle_rad), 0);
        if (IsHidden(end)) continue;
        rays.ends.push_back(end.cast<float>());
        rays.sigma_m.push_back(static_cast<float>(kSigma_m));
      }
    }
    return rays;
  }

  static OrientedPoints Seen() {
    RandomDraws random(2, 0);
    OrientedPoints points;
    points.viewpoint = kEye;
    while (points.size() < 900) {
      const double y = random.Uniform(-kRadius_m, kRadius_m);
      const Vector2 x(random.Uniform(-kRadius_m, kRadius_m), y);
      if (x.norm() > kRadius_m) continue;
      const Vector3 p(x.x(), x.y(), kHeight_m);
      const Vector3 ray = (p - kEye).normalized();
      points.points.push_back((p + kSigma_m * random.Normal() * ray).cast<float>());
      points.normals.push_back(Eigen::Vector3f::UnitZ());
      points.sigma_m.push_back(static_cast<float>(kSigma_m));
      points.normal_sigma_rad.push_back(0.05f);
      points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
    }
    return points;
  }

 private:
  // True if the end is behind the cup: its ray comes nearer to the axis than the cup's radius at
  // that height.
  static bool IsHidden(const Vector3& end) {
    const Vector3 ray = (end - kEye).normalized();
    for (double t = 0; t < (end - kEye).norm(); t += 0.001) {
      const Vector3 p = kEye + t * ray;
      if (p.z() > kHeight_m) continue;
      if (p.head<2>().norm() < kRadius_m - kSlope * (kHeight_m - p.z()) + 0.003) return true;
    }
    return false;
  }
};

TEST(FitPrimitive, TellsACupFromACanByTheRaysBesideItsFoot) {
  const Fixture f(RoundTop::Seen());
  FitContext context = f.Context();
  const auto blind = FitPrimitive(PrimitiveKind::kUprightCylinder, {}, kFarAway, context);
  context.free = FreeRaysPast(f.points, context.ground, RoundTop::RaysBesideTheCup());
  ASSERT_FALSE(context.free.rays.empty());
  const auto can = FitPrimitive(PrimitiveKind::kUprightCylinder, {}, kFarAway, context);
  const auto cup = FitPrimitive(PrimitiveKind::kUprightCone, {}, kFarAway, context);
  ASSERT_TRUE(blind && can && cup);
  EXPECT_GT(can->value, blind->value + kDecisive);
  EXPECT_GT(can->value, cup->value + kDecisive);
  EXPECT_GT(SlopeOf(cup->kind, cup->parameters), RoundTop::kSlope - 0.05);
}

// Only the part of a can above this height is visible: either the ground is lower, or something
// hides the foot.
TEST(FindBetterPrimitive, StandsOnNoGroundBelowWhichRaysPassed) {
  constexpr float kInView_m = 0.2f;
  const Vector3 foot(0, 0, 0);
  OrientedPoints seen;
  seen.viewpoint = kEye;
  PrimitiveParameters can(4);
  can << 0, 0, 0.1, 0.04;
  const OrientedPoints low = SeenOf(PrimitiveKind::kUprightCylinder, can, kSigma_m);
  for (std::size_t i = 0; i < low.size(); ++i) {
    seen.points.push_back(low.points[i] + Eigen::Vector3f(0, 0, kInView_m));
    seen.normals.push_back(low.normals[i]);
    seen.sigma_m.push_back(low.sigma_m[i]);
    seen.normal_sigma_rad.push_back(low.normal_sigma_rad[i]);
    seen.cloud_index.push_back(low.cloud_index[i]);
  }
  const Fixture f(seen);
  FitContext context = f.Context();
  const auto blind = FindBetterPrimitive(context, {});
  ASSERT_TRUE(blind.has_value());
  EXPECT_NEAR(std::get<Cylinder>(blind->solid.shape).length_m, 0.3, 0.005);
  // Rays beside the can, and as many through the lower half of the part that was completed.
  PassingRays rays;
  rays.weight = 10;
  for (const double aside_m : {-0.1, -0.06, 0.0, 0.06, 0.1}) {
    for (double height_m = 0.02; height_m < 0.15; height_m += 0.01) {
      const Vector3 beside = foot + Vector3(0.447 * aside_m, -0.894 * aside_m, height_m);
      rays.ends.push_back((beside + 0.2 * (beside - kEye).normalized()).cast<float>());
      rays.sigma_m.push_back(static_cast<float>(kSigma_m));
    }
  }
  context.free = FreeRaysPast(f.points, context.ground, rays);
  ASSERT_GT(context.free.rays.size(), 40u);
  ASSERT_LE(CrossingRayShare(blind->solid, context.free), 0.25);
  EXPECT_FALSE(FindBetterPrimitive(context, {}).has_value());
}

// A wall of 10 by 15 cm across the x axis that is bent about the z axis by `bend_m` at its sides.
OrientedPoints WallBentBy(double bend_m, double noise_m) {
  RandomDraws random(3, 0);
  OrientedPoints points;
  points.viewpoint = Vector3(-1.5, 0, 0.7);
  while (points.size() < 900) {
    const double y = random.Uniform(-1, 1);
    const Vector3 p{bend_m * (y * y - 0.5) + noise_m * random.Normal(), 0.05 * y,
                    random.Uniform(0.01, 0.15)};
    points.points.push_back(p.cast<float>());
    points.normals.push_back(-Eigen::Vector3f::UnitX());
    points.sigma_m.push_back(static_cast<float>(noise_m));
    points.normal_sigma_rad.push_back(0.2f);
    points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
  }
  return points;
}

TEST(LooksFlat, IsNoBoardThatHoldsABentWall) {
  for (const double bend_m : {0.0, 0.003, 0.012}) {
    const Fixture f(WallBentBy(bend_m, 0.0035));
    Solid board;
    board.shape = Box{.size_m = {0.012, 0.1, 0.15}};
    board.X_MS = Eigen::Translation3d(Vector3(0, 0, 0.075) - f.points.origin_L);
    for (std::uint32_t i = 0; i < f.points.size(); ++i) board.inliers.push_back(i);
    EXPECT_EQ(LooksFlat(board, f.Context()), bend_m < 0.01) << bend_m;
    board.shape = Box{.size_m = {0.04, 0.1, 0.15}};  // its faces are farther apart than their gates
    EXPECT_TRUE(LooksFlat(board, f.Context()));
  }
}

TEST(FindBetterPrimitive, IsABoardWhereItIsFlat) {
  PrimitiveParameters board(6);
  board << 0, 0, 0.5 * std::numbers::pi - std::atan2(0.3, 0.6), 0.012, 0.1, 0.15;
  OrientedPoints seen = SeenOf(PrimitiveKind::kUprightBox, board, 0.0035);
  for (float& sigma_m : seen.sigma_m) sigma_m = 0.0035f;
  const Fixture f(seen);
  const auto solid = FindBetterPrimitive(f.Context(), {});
  ASSERT_TRUE(solid.has_value());
  EXPECT_TRUE(std::holds_alternative<Box>(solid->solid.shape));
}

TEST(FitPrimitive, CountsWhatTheSlowWarpIsLikelyToDoForLittle) {
  const OrientedPoints seen = RoundTop::Seen();
  const Fixture f(seen);
  const Solid flat{
      .X_MS =
          Pose(Eigen::Translation3d(Vector3(0, 0, 0.5 * RoundTop::kHeight_m) - f.points.origin_L)),
      .shape = Cylinder{.radius_m = RoundTop::kRadius_m, .length_m = RoundTop::kHeight_m},
      .inliers = {},
      .parameter_sigma = {}};
  OrientedPoints warped = seen, rough = seen;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const Vector3 ray = (seen.points[i].cast<double>() - kEye).normalized();
    const double slow = seen.points[i].y() / RoundTop::kRadius_m;  // of 1 mm at the borders
    warped.points[i] += (0.001 * slow * ray).cast<float>();
    rough.points[i] += ((i % 2 == 0 ? 0.001 : -0.001) * std::abs(slow) * ray).cast<float>();
  }
  const Fixture of_warped(warped), of_rough(rough);
  const auto value = [&](const Fixture& g) {
    Solid at = flat;
    at.X_MS = Eigen::Translation3d(f.points.origin_L - g.points.origin_L) * at.X_MS;
    return FitScoreOf({at}, 4, g.Context()).value;
  };
  EXPECT_LT(value(of_warped) - value(f), 0.5 * (value(of_rough) - value(f)));
}

// The parameters of a kind make a solid, and the solid gives the parameters back.
TEST(PrimitiveKind, ParametersSurviveTheSolid) {
  for (const Case& c :
       {Case{"", PrimitiveKind::kUprightCone, {0.01, 0.02, 0.1, 0.045, 0.15}},
        Case{"", PrimitiveKind::kLyingCone, {0.01, 0.02, 0.4, 0.03, 0.1, 0.12}},
        Case{"", PrimitiveKind::kUprightCylinder, {0.01, 0.02, 0.1, 0.015}},
        Case{"", PrimitiveKind::kLyingCylinder, {0.01, 0.02, 0.4, 0.02, 0.1}},
        Case{"", PrimitiveKind::kTiltedBox, {0.01, 0.02, 0.08, 0.3, 0.4, 0.2, 0.06, 0.1, 0.05}}}) {
    const PrimitiveParameters x = ParametersOf(c);
    const auto back = perception::ParametersOf(c.kind, Place(c.kind, x));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - x).cwiseAbs().maxCoeff(), 1e-12) << static_cast<int>(c.kind);
  }
}

TEST(PrimitiveKind, WhatLiesTouchesTheGroundAlongALine) {
  PrimitiveParameters x(6);
  x << 0.01, 0.02, 0.4, 0.03, 0.1, 0.12;
  const PlacedPrimitive cup = Place(PrimitiveKind::kLyingCone, x);
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
