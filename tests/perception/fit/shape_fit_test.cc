#include "perception/fit/shape_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "perception/cloud/tolerances.h"
#include "tests/perception/fit/exact_fits.h"

namespace cwm::perception {
namespace {

const ConeModel kCan{.point = Vector3(0, 0, 0.05), .radius_m = 0.04};
const ConeModel kCanAbove{.point = Vector3(0, 0, 0.3), .radius_m = 0.04};
constexpr int kCanRows = 30, kRowsAbove = 11;
constexpr double kCanArc_rad = 140 * kDegree;

// One wall in two pieces, about 10 cm apart.
ExactPoints WallInTwoPieces() {
  ExactPoints exact;
  exact.seen.viewpoint = Vector3(1, 0, 0.3);
  exact.AddWall(kCan, kCanRows, kCanArc_rad);
  exact.AddWall(kCanAbove, kRowsAbove, kCanArc_rad);
  return exact;
}

// A square of 9 cm that leans by `lean_rad` about y.
ExactPoints LeaningSquare(double lean_rad) {
  ExactPoints exact;
  exact.seen.viewpoint = Vector3(0, 0, 1);
  exact.AddGrid(Vector3(0, 0, 0), Vector3(std::sin(lean_rad), 0, std::cos(lean_rad)), 31, 31);
  return exact;
}

ShapeFit FinishedPlane(const ExactFits& fits, double lean_rad) {
  const PlaneModel start{.point = fits.Local(Vector3::Zero()),
                         .normal = Vector3(std::sin(lean_rad), 0, std::cos(lean_rad))};
  const auto rough = FitShape(start, AxisFreedom::kFree, fits.Context(), fits.available);
  if (!rough) return {};
  return FinishFit(*rough, fits.Context(), fits.available).value_or(ShapeFit{});
}

TEST(CanonicalAxis, PointsUpOrToXOrToY) {
  const Vector3 up = Vector3::UnitZ();
  EXPECT_EQ(CanonicalAxis(Vector3(0.6, 0, -0.8), up), Vector3(-0.6, 0, 0.8));
  EXPECT_EQ(CanonicalAxis(Vector3(-0.6, 0, 0.8), up), Vector3(-0.6, 0, 0.8));
  // Half a degree from level.
  EXPECT_EQ(CanonicalAxis(Vector3(-1, 0, 0.0087), up), Vector3(1, 0, -0.0087));
  EXPECT_EQ(CanonicalAxis(Vector3(0.0087, -1, 0), up), Vector3(-0.0087, 1, 0));
}

TEST(FitShape, EndsOnTheLargestPieceOfWhatIsAvailable) {
  ExactFits fits(WallInTwoPieces());
  const CylinderModel start{.point = fits.Local(Vector3(0.001, 0, 0.05)), .radius_m = 0.039};
  const auto is_above = [](const Vector3& p) { return p.z() > 0.2; };
  const auto columns = static_cast<std::size_t>(ExactPoints::ColumnsOf(kCan, kCanArc_rad));
  const auto can = FitShape(start, AxisFreedom::kFree, fits.Context(), fits.available);
  ASSERT_TRUE(can);
  const auto* cylinder = std::get_if<CylinderModel>(&can->model);
  ASSERT_NE(cylinder, nullptr);
  EXPECT_NEAR(cylinder->radius_m, 0.04, 1e-5);
  EXPECT_NEAR(std::abs(cylinder->axis.z()), 1, 1e-6);
  EXPECT_LT(fits.Made(cylinder->point).head<2>().norm(), 1e-4);
  EXPECT_EQ(can->inliers.size(), kCanRows * columns);
  EXPECT_EQ(fits.CountOf(can->inliers, is_above), 0u);
  fits.TakeAway([&](const Vector3& p) { return !is_above(p); });
  const auto above = FitShape(start, AxisFreedom::kHeld, fits.Context(), fits.available);
  ASSERT_TRUE(above);
  EXPECT_EQ(above->axis, AxisFreedom::kHeld);
  EXPECT_EQ(above->inliers.size(), kRowsAbove * columns);
  EXPECT_EQ(ConnectedInliers(above->model, fits.Context(), fits.available), above->inliers);
}

TEST(FitShape, RefusesWhatIsTooSmallOrTooWide) {
  ExactFits fits(WallInTwoPieces());
  const auto is_found = [&fits](const ModelerOptions& options) {
    fits.options = options;
    const CylinderModel start{.point = fits.Local(Vector3(0, 0, 0.05)), .radius_m = 0.04};
    return FitShape(start, AxisFreedom::kFree, fits.Context(), fits.available).has_value();
  };
  EXPECT_TRUE(is_found({}));
  EXPECT_FALSE(is_found({.max_radius_m = 0.039}));
  EXPECT_FALSE(is_found({.min_radius_m = 0.041}));
  // More than the larger piece has, but not more than both have.
  EXPECT_TRUE(is_found({.min_inliers = kCanRows * 34}));
  EXPECT_FALSE(is_found({.min_inliers = kCanRows * 34 + 1}));
  fits.TakeAway([](const Vector3&) { return true; });
  EXPECT_FALSE(is_found({}));
}

// 80 independent samples. A lean of 0.3 degrees moves them by 0.14 sigma rms, which costs less than
// the two parameters (ln 80 each); a lean of two degrees moves them by 0.9 sigma and costs 66.
TEST(FinishFit, MakesANormalPointUpWhereThatCostsLittle) {
  const ExactFits nearly(LeaningSquare(0.3 * kDegree)), leaning(LeaningSquare(2 * kDegree));
  const ShapeFit snapped = FinishedPlane(nearly, 0.3 * kDegree);
  ASSERT_EQ(snapped.inliers.size(), 961u);
  EXPECT_EQ(snapped.axis, AxisFreedom::kHeld);
  EXPECT_NEAR((std::get<PlaneModel>(snapped.model).normal - Vector3::UnitZ()).norm(), 0, 1e-12);
  ASSERT_EQ(snapped.covariance.rows(), PlaneModel::kParameterCount);
  EXPECT_DOUBLE_EQ(snapped.covariance(PlaneModel::kFirstTilt, PlaneModel::kFirstTilt),
                   kUpSigma_rad * kUpSigma_rad);
  const ShapeFit free = FinishedPlane(leaning, 2 * kDegree);
  ASSERT_EQ(free.inliers.size(), 961u);
  EXPECT_EQ(free.axis, AxisFreedom::kFree);
  EXPECT_NEAR(std::get<PlaneModel>(free.model).normal.x(), std::sin(2 * kDegree), 1e-5);
}

TEST(Criterion, WeighsSquaresInSigmaAndParametersByIndependentSamples) {
  ExactPoints exact;
  exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 30, 20);
  exact.AddGrid(Vector3(0.2, 0, 0.05), -Vector3::UnitX(), 30, 20);
  const ExactFits fits(exact);
  const FitContext context = fits.Context();
  const Criterion plain = CriterionOf(2, 120, 3, context);  // 10 samples
  EXPECT_NEAR(plain.value, 2 * 10 + 3 * std::log(10), 1e-9);
  EXPECT_NEAR(plain.rms_sigma, std::sqrt(2), 1e-9);
  EXPECT_EQ(CriterionOf(2, 0, 3, context).value, 0);
  // One sigma below half of the 1200 points. The others, which make it 100 samples in all, face
  // elsewhere.
  const PlaneModel floor{.point = fits.Local(Vector3(0, 0, -0.001))};
  const Criterion of_one = EvaluateCriterion(floor, AxisFreedom::kFree, context, fits.all);
  EXPECT_NEAR(of_one.value, 100 * (1 + 9) / 2.0 + 3 * std::log(100), 1e-3);
  const Criterion held = EvaluateCriterion(floor, AxisFreedom::kHeld, context, fits.all);
  EXPECT_NEAR(of_one.value - held.value, 2 * std::log(100), 1e-9);
  const PlaneModel side{.point = fits.Local(Vector3(0.2, 0, 0)), .normal = -Vector3::UnitX()};
  const Criterion of_both = EvaluateCriterion({floor, side}, context, fits.all);
  EXPECT_NEAR(of_both.value, 100 * (1 + 0) / 2.0 + 6 * std::log(100), 1e-3);
}

}  // namespace
}  // namespace cwm::perception
