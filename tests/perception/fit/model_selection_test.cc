#include "perception/fit/model_selection.h"
#include "perception/cloud/tolerances.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/perception/fit/exact_fits.h"

namespace cwm::perception {
namespace {

constexpr int kSeenRows = 33;  // rows of points on walls: 96 mm
constexpr double kSeenArc = 140 * kDegree;

// Runs the model selection on a scene of exact points.
struct SelectionOf {
  explicit SelectionOf(const ExactPoints& exact)
      : fits(exact), candidates(fits.points, fits.connectivity, 1) {}

  std::optional<ShapeFit> From(const AnyModel& found) {
    candidates.Add(found);
    const Candidate* leader = candidates.Leader();
    if (leader == nullptr) return std::nullopt;
    return SelectModel(*leader, candidates, fits.Context());
  }

  ExactFits fits;
  CandidateList candidates;
};

ExactPoints SeenWall(const ConeModel& wall) {
  ExactPoints exact;
  exact.seen.viewpoint = Vector3(1, 0, 0.3);
  exact.AddWall(wall, kSeenRows, kSeenArc);
  return exact;
}

TEST(CurvedEvidence, IsTheArcThatTheInliersFill) {
  const ConeModel wall{.radius_m = 0.05};
  ExactPoints part, ring, cap;
  part.AddWall(wall, 30, 120 * kDegree);
  ring.AddWall(wall, 30, 360 * kDegree);
  const auto of_wall = [&wall](const ExactPoints& exact) {
    const ExactFits fits(exact);
    ShapeFit fit;
    fit.inliers = fits.all;
    ConeModel local = wall;
    local.point = fits.Local(wall.point);
    return MeasureEvidence(local, fit, fits.Context());
  };
  // From the 3rd to the 97th percentile of 120 degrees: 113 degrees, to the nearest column of 3 mm
  // (3.4 degrees).
  const CurvedEvidence third = of_wall(part);
  EXPECT_EQ(third.radius_m, 0.05);
  EXPECT_NEAR(third.arc_rad, 112.8 * kDegree, 3.5 * kDegree);
  EXPECT_NEAR(third.chord_m, 0.0833, 0.002);
  EXPECT_NEAR(third.sagitta_m, 0.0223, 0.002);
  const CurvedEvidence whole = of_wall(ring);
  EXPECT_NEAR(whole.chord_m, 0.1, 1e-9);
  EXPECT_NEAR(whole.sagitta_m, 0.05, 1e-9);
  // 95 % of the area of a cap of 40 degrees lies within 38.9 degrees of its middle.
  const SphereModel ball{.radius_m = 0.05};
  cap.AddCap(ball, 40 * kDegree, 500);
  const ExactFits fits(cap);
  ShapeFit fit;
  fit.inliers = fits.all;
  SphereModel local = ball;
  local.center = fits.Local(ball.center);
  EXPECT_NEAR(MeasureEvidence(local, fit, fits.Context()).arc_rad, 2 * 38.9 * kDegree, 1 * kDegree);
}

TEST(CurvedEvidence, IsSignificantBeyondWhatNoiseBendsAndWarpLifts) {
  // On a sixth of a turn the chord equals the radius.
  const CurvedEvidence arc{.radius_m = 0.05,
                           .arc_rad = 60 * kDegree,
                           .chord_m = 0.05,
                           .sagitta_m = 0.05 * (1 - std::cos(30 * kDegree))};
  // 1/R is 20 per metre. Four times 26.8 * 1 mm / (5 * (5 cm)^2) is 8.6; without the 5 it is 43.
  EXPECT_TRUE(IsSignificant(arc, 0.001, 25));
  EXPECT_FALSE(IsSignificant(arc, 0.001, 1));
  EXPECT_FALSE(IsSignificant(arc, 0.001, 25, 10));
  CurvedEvidence narrow = arc;
  narrow.arc_rad = 34 * kDegree;
  EXPECT_FALSE(IsSignificant(narrow, 0.001, 25));
  // A radius of 4 mm: the arc is 0.54 mm high, no more than the sensor's warp.
  const CurvedEvidence thin{
      .radius_m = 0.004, .arc_rad = 60 * kDegree, .chord_m = 0.004, .sagitta_m = 0.00054};
  EXPECT_FALSE(IsSignificant(thin, 1e-5, 100));
}

TEST(SelectModel, TakesAFlatPatchForAPlaneWhateverFoundIt) {
  ExactPoints exact;
  exact.seen.viewpoint = Vector3(0, 0, 1);
  exact.AddGrid(Vector3(0, 0, 0.2), Vector3::UnitZ(), 31, 31);
  SelectionOf selection(exact);
  const SphereModel ball{.center = selection.fits.Local(Vector3(0, 0, -0.2)), .radius_m = 0.4};
  const auto plane = selection.From(ball);
  ASSERT_TRUE(plane);
  ASSERT_TRUE(IsPlane(plane->model));
  EXPECT_EQ(plane->inliers.size(), 961u);
  EXPECT_NEAR(std::get<PlaneModel>(plane->model).normal.z(), 1, 1e-9);
  EXPECT_TRUE(IsSignificantlyCurved(*plane, selection.fits.Context()));
  selection.fits.options.min_inliers = 962;
  EXPECT_FALSE(selection.From(ball)) << "of fewer points than a shape must have";
}

TEST(SelectModel, TakesTheUprightCylinderOfACanThatAPlaneFound) {
  const ConeModel wall{.point = Vector3(0, 0, 0.05), .radius_m = 0.04};
  SelectionOf selection(SeenWall(wall));
  const PlaneModel strip{.point = selection.fits.Local(Vector3(0.0395, 0, 0.05)),
                         .normal = Vector3::UnitX()};
  const auto can = selection.From(strip);
  ASSERT_TRUE(can);
  const auto* cylinder = std::get_if<CylinderModel>(&can->model);
  ASSERT_NE(cylinder, nullptr);
  EXPECT_EQ(can->axis, AxisFreedom::kHeld);
  EXPECT_NEAR(cylinder->radius_m, 0.04, 1e-4);
  EXPECT_LT(selection.fits.Made(cylinder->point).head<2>().norm(), 1e-4);
  EXPECT_EQ(can->inliers.size(), selection.fits.points.size());
}

TEST(SelectModel, TakesTheUprightConeOfACupThatACylinderFound) {
  const ConeModel wall{.point = Vector3(0, 0, 0.05), .radius_m = 0.04, .slope = 0.15};
  SelectionOf selection(SeenWall(wall));
  const auto cup = selection.From(
      CylinderModel{.point = selection.fits.Local(wall.point), .radius_m = wall.radius_m});
  ASSERT_TRUE(cup);
  const auto* cone = std::get_if<ConeModel>(&cup->model);
  ASSERT_NE(cone, nullptr);
  EXPECT_EQ(cup->axis, AxisFreedom::kHeld);
  EXPECT_NEAR(cone->slope, 0.15, 1e-3);
  EXPECT_EQ(cup->inliers.size(), selection.fits.points.size());
}

}  // namespace
}  // namespace cwm::perception
