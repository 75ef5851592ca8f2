#include "tests/benchmarks/quality/shape_matching.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "tests/benchmarks/quality/parameter_calibration.h"
#include "tests/benchmarks/quality/shape_tally.h"

namespace cwm::benchmarks {
namespace {

using perception::DetectedObject;
using perception::SceneInterpretation;

constexpr double kDepth_m = 0.8;

// One object in front of a camera at the origin of the world, z forward, without noise.
class OneObject : public ::testing::Test {
 protected:
  void Stand(const Shape& shape, const Pose& X_WO) {
    scene_.objects = {{.name = "object", .parts = {{.shape = shape}}, .X_WO = X_WO}};
    scan_ = perception::Scan(scene_, camera_, {.noiseless = true});
    interpretation_.labels.assign(scan_.cloud.size(), 0);
  }

  // Adds a found object of one shape that explains every point except each `left_out`-th.
  void Find(const Shape& shape, const Pose& X_WO, std::uint32_t left_out = 0) {
    auto model = std::make_shared<HybridModel>();
    model->shapes.push_back({.shape = shape, .fit = FitQuality{}});
    DetectedObject& object = interpretation_.objects.emplace_back();
    object.X_WO = X_WO;
    object.model = model;
    const auto label = static_cast<std::uint32_t>(10 * (interpretation_.objects.size() + 1) + 1);
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < scan_.object.size(); ++i) {
      if (scan_.object[i] < 0) continue;
      if (left_out != 0 && count++ % left_out == 0) continue;
      interpretation_.labels[i] = label;
    }
  }

  InterpretedView view() const { return {scene_, camera_, scan_, interpretation_}; }

  perception::SimulatedScene scene_;
  perception::PinholeCamera camera_;
  perception::SimulatedCloud scan_;
  SceneInterpretation interpretation_;
};

Pose At(double x_m, double y_m, double z_m) { return MakeTranslation(x_m, y_m, z_m); }

// The pose of a shape seen from the side: its z axis along the camera's y.
Pose Upright(double x_m = 0) {
  return MakePose({x_m, 0, kDepth_m},
                  Quaternion(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitX())));
}

TEST_F(OneObject, FoundAsItIsHasNoErrors) {
  Stand(Cylinder{.radius_m = 0.04, .length_m = 0.12}, Upright());
  Find(Cylinder{.radius_m = 0.04, .length_m = 0.12}, Upright());
  const SceneShapes shapes = MatchShapes(view());
  ASSERT_EQ(shapes.outcomes.size(), 1u);
  EXPECT_EQ(shapes.outcomes[0].outcome, Outcome::kFound);
  EXPECT_DOUBLE_EQ(shapes.outcomes[0].iou, 1);
  EXPECT_TRUE(shapes.spurious.empty());
  const ShapeErrors& errors = shapes.outcomes[0].errors;
  EXPECT_NEAR(*errors.radius_m, 0, 1e-12);
  EXPECT_NEAR(*errors.axis_rad, 0, 1e-9);
  EXPECT_NEAR(*errors.centre_m, 0, 1e-12);
  ASSERT_EQ(errors.length_m.size(), 1u) << "both ends are in view";
  EXPECT_NEAR(errors.length_m[0], 0, 1e-12);
  EXPECT_FALSE(errors.half_angle_rad.has_value());
}

TEST_F(OneObject, ErrorsAreDifferencesWhicheverWayTheAxisPoints) {
  Stand(Cylinder{.radius_m = 0.04, .length_m = 0.12}, Upright());
  const double tilt_rad = 0.02;
  Pose found = Upright(0.003);
  found.rotate(Eigen::AngleAxisd(std::numbers::pi - tilt_rad, Vector3::UnitX()));
  Find(Cylinder{.radius_m = 0.042, .length_m = 0.115}, found);
  const ShapeErrors errors = MatchShapes(view()).outcomes[0].errors;
  EXPECT_NEAR(*errors.radius_m, 0.002, 1e-12);
  EXPECT_NEAR(*errors.axis_rad, tilt_rad, 1e-9);
  EXPECT_NEAR(errors.length_m[0], 0.005, 1e-12);
  EXPECT_NEAR(*errors.centre_m, 0.003, 1e-12);
}

TEST_F(OneObject, HalfAngleOfAConeHasASign) {
  Stand(Cone{.radius_bottom_m = 0.03, .radius_top_m = 0.04, .length_m = 0.1}, Upright());
  Find(Cone{.radius_bottom_m = 0.04, .radius_top_m = 0.03, .length_m = 0.1}, Upright());
  const double half_angle_rad = std::atan2(0.01, 0.1);
  const SceneShapes shapes = MatchShapes(view());
  EXPECT_NEAR(*shapes.outcomes[0].errors.half_angle_rad, 2 * half_angle_rad, 1e-9);
  Pose turned = Upright();
  turned.rotate(Eigen::AngleAxisd(std::numbers::pi, Vector3::UnitX()));
  interpretation_.objects.clear();
  Find(Cone{.radius_bottom_m = 0.04, .radius_top_m = 0.03, .length_m = 0.1}, turned);
  EXPECT_NEAR(*MatchShapes(view()).outcomes[0].errors.half_angle_rad, 0, 1e-9);
}

TEST_F(OneObject, EdgesOfABoxArePairedByDirectionAndCountWhereBothEndsAreSeen) {
  Stand(Box{.size_m = {0.1, 0.2, 0.06}}, At(0, 0, kDepth_m));  // only its face is seen
  Pose turned = At(0, 0, kDepth_m);
  turned.rotate(Eigen::AngleAxisd(std::numbers::pi / 2, Vector3::UnitZ()));
  Find(Box{.size_m = {0.203, 0.1, 0.01}}, turned);
  const ShapeErrors errors = MatchShapes(view()).outcomes[0].errors;
  ASSERT_EQ(errors.length_m.size(), 2u);
  EXPECT_NEAR(errors.length_m[0], 0, 1e-9);
  EXPECT_NEAR(errors.length_m[1], 0.003, 1e-9);
  EXPECT_NEAR(*errors.box_axis_rad, 0, 1e-7);
}

TEST_F(OneObject, OfAnotherTypeIsAsRightWhereItsSurfaceIsTheSame) {
  const double length_m = 0.1, slope_m = 0.0004;  // well within half a sigma, 0.75 mm at 0.8 m
  Stand(Cylinder{.radius_m = 0.04, .length_m = length_m}, Upright());
  Find(
      Cone{.radius_bottom_m = 0.04 - slope_m, .radius_top_m = 0.04 + slope_m, .length_m = length_m},
      Upright());
  const SceneShapes shapes = MatchShapes(view());
  EXPECT_EQ(shapes.outcomes[0].outcome, Outcome::kEquivalent);
  EXPECT_TRUE(shapes.spurious.empty());
  EXPECT_LT(*shapes.outcomes[0].errors.radius_m, slope_m);
}

TEST_F(OneObject, OfAnotherTypeElsewhereIsWrongAndInvented) {
  Stand(Cylinder{.radius_m = 0.04, .length_m = 0.1}, Upright());
  Find(Box{.size_m = {0.08, 0.08, 0.1}}, Upright());
  const SceneShapes shapes = MatchShapes(view());
  EXPECT_EQ(shapes.outcomes[0].outcome, Outcome::kWrongType);
  ASSERT_EQ(shapes.spurious.size(), 1u);
  EXPECT_EQ(shapes.spurious[0].what, Invention::kWrongType);
  EXPECT_EQ(*shapes.outcomes[0].errors.radius_m, std::numeric_limits<double>::infinity());
}

TEST_F(OneObject, HalfOfItsPointsAreNotEnough) {
  const Sphere ball{.radius_m = 0.05};
  Stand(ball, At(0, 0, kDepth_m));
  Find(ball, At(0, 0, kDepth_m), 2);
  const SceneShapes shapes = MatchShapes(view());
  EXPECT_EQ(shapes.outcomes[0].outcome, Outcome::kSplit);
  ASSERT_EQ(shapes.spurious.size(), 1u);
  EXPECT_EQ(shapes.spurious[0].what, Invention::kFragment);
  EXPECT_EQ(*shapes.outcomes[0].errors.centre_m, std::numeric_limits<double>::infinity());
}

TEST_F(OneObject, SeenOrNotTheWorldMayBeAnyFrame) {
  const Sphere ball{.radius_m = 0.05};
  Stand(ball, At(0.1, 0, kDepth_m));
  interpretation_.X_WC = MakePose({3, -2, 1}, Quaternion(Eigen::AngleAxisd(1.0, Vector3::UnitX())));
  Find(ball, interpretation_.X_WC * At(0.1, 0, kDepth_m));
  const SceneShapes shapes = MatchShapes(view());
  EXPECT_EQ(shapes.outcomes[0].outcome, Outcome::kFound);
  EXPECT_NEAR(*shapes.outcomes[0].errors.centre_m, 0, 1e-12);
}

TEST_F(OneObject, TallyCountsWhatHasPointsEnough) {
  Stand(Sphere{.radius_m = 0.004}, At(0, 0, kDepth_m));  // about 20 pixels
  ShapeTally tally;
  tally.Add("few points", view(), MatchShapes(view()));
  EXPECT_EQ(tally.true_count(), 0);
  Stand(Sphere{.radius_m = 0.05}, At(0, 0, kDepth_m));
  tally.Add("missing", view(), MatchShapes(view()));
  EXPECT_EQ(tally.true_count(), 1);
  EXPECT_EQ(tally.found_share(), 0);
  ASSERT_EQ(tally.errors().radius_m.size(), 1u);
  EXPECT_TRUE(std::isinf(tally.errors().radius_m[0]));
  ASSERT_EQ(tally.failures().size(), 1u);
  EXPECT_EQ(tally.failures()[0].scene, "missing");
}

TEST(ParameterCalibration, CountsErrorsWithinOneDeviationOfParametersThatHaveOne) {
  const TrueShape truth{.shape = Sphere{.radius_m = 0.05}};
  FoundShape found{.part = {.shape = Sphere{.radius_m = 0.052}, .fit = FitQuality{}}};
  found.X_WS.translation() = Vector3(0.001, 0.003, 0);
  found.part.fit->parameter_sigma = {0.002, 0.002, 0, 0.001};
  ParameterCalibration calibration;
  calibration.Add(truth, found);
  EXPECT_EQ(calibration.parameters().at("sphere centre").count, 2);
  EXPECT_EQ(calibration.parameters().at("sphere centre").within, 1);
  EXPECT_EQ(calibration.parameters().at("sphere radius").within, 0);
  EXPECT_EQ(calibration.all().count, 3);
}

TEST(ParameterCalibration, TakesThePointOfTheAxisNearestToTheFoundOne) {
  const TrueShape truth{.shape = Cylinder{.radius_m = 0.05, .length_m = 0.1}};
  FoundShape found{
      .part = {.shape = Cylinder{.radius_m = 0.05, .length_m = 0.2}, .fit = FitQuality{}}};
  found.X_WS = MakePose({0.001, 0, 0.3}, Quaternion(0, 1, 0, 0));  // upside down, along the axis
  found.part.fit->parameter_sigma = {0.002, 0.002, 0.002, 0.01, 0.01, 0.01, 0.001};
  ParameterCalibration calibration;
  calibration.Add(truth, found);
  EXPECT_EQ(calibration.all().count, 7);
  EXPECT_EQ(calibration.all().within, 7);
}

}  // namespace
}  // namespace cwm::benchmarks
