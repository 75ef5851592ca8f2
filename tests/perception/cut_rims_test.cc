// Rounded rims of round objects, seen by the virtual scanner.
#include "perception/refinement/complete/cut_rims.h"

#include <gtest/gtest.h>

#include <utility>

#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kRadius_m = 0.09, kHeight_m = 0.1;

PinholeCamera Camera() {
  PinholeCamera camera;
  const Vector3 forward = Vector3(1, 0, -0.75).normalized(), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = Vector3(0, 0, 0.05) - 0.8 * forward;
  return camera;
}

// A tin on a table; the rim of its lid is chamfered by `cut_m` at 45 degrees.
SimulatedScene Tin(double cut_m) {
  SimulatedObject table{.name = "table",
                        .parts = {{MakeTranslation(0, 0, -0.015), Box{{1.2, 1.0, 0.03}}}},
                        .X_WO = Pose::Identity(),
                        .is_support = true};
  const double body_m = kHeight_m - cut_m;
  SimulatedObject tin{.name = "tin",
                      .parts = {{MakeTranslation(0, 0, 0.5 * body_m), Cylinder{kRadius_m, body_m}}},
                      .X_WO = Pose::Identity(),
                      .is_support = false};
  if (cut_m > 0) {
    tin.parts.push_back(
        {MakeTranslation(0, 0, body_m + 0.5 * cut_m),
         Cone{.radius_bottom_m = kRadius_m, .radius_top_m = kRadius_m - cut_m, .length_m = cut_m}});
  }
  return {{table, tin}};
}

SceneInterpretation Interpret(const PointCloud& cloud) {
  InterpretOptions options;
  options.X_WC = Camera().X_WC;
  absl::StatusOr<SceneInterpretation> scene = InterpretScene(cloud, options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

TEST(CutRoundedRims, OfATinBecomeATruncatedConeOnItsCylinder) {
  const SimulatedCloud scan = Scan(Tin(0.01), Camera(), {});
  const SceneInterpretation scene = Interpret(scan.cloud);
  ASSERT_EQ(scene.objects.size(), 1u);
  const DetectedObject& tin = scene.objects[0];
  ASSERT_EQ(tin.model->shapes.size(), 2u);
  const ShapePart &body = tin.model->shapes[0], &rim = tin.model->shapes[1];
  ASSERT_EQ(KindOf(body.shape), ShapeKind::kCylinder);
  ASSERT_EQ(KindOf(rim.shape), ShapeKind::kCone);
  const auto& cylinder = std::get<Cylinder>(body.shape);
  const auto& cone = std::get<Cone>(rim.shape);
  // The cylinder was fitted to the rim's points too, and so ends some 1 mm short of the seam.
  EXPECT_NEAR(cone.length_m, 0.01, 0.003);
  EXPECT_NEAR(cone.radius_bottom_m, cylinder.radius_m, 1e-9);
  EXPECT_NEAR(cone.radius_bottom_m - cone.radius_top_m, cone.length_m, 1e-9);
  EXPECT_NEAR(cylinder.length_m + cone.length_m, kHeight_m, 0.003);
  // The cone begins where the cylinder ends.
  const Vector3 seam = body.X_OS * Vector3(0, 0, 0.5 * cylinder.length_m);
  EXPECT_LT((seam - rim.X_OS * Vector3(0, 0, -0.5 * cone.length_m)).norm(), 1e-9);
  // The lid's points count as the rim's inliers.
  ASSERT_TRUE(body.fit && rim.fit);
  EXPECT_EQ(rim.role, PartRole::kFitted);
  EXPECT_GT(rim.fit->inlier_count, body.fit->inlier_count);
  EXPECT_LE(rim.fit->inlier_count + body.fit->inlier_count, tin.model->point_count);
  EXPECT_LT(rim.fit->rms_m, 0.004);
}

TEST(CutRoundedRims, LeavesSharpEndsAsTheyAre) {
  const SimulatedCloud scan = Scan(Tin(0), Camera(), {});
  const SceneInterpretation scene = Interpret(scan.cloud);
  ASSERT_EQ(scene.objects.size(), 1u);
  ASSERT_EQ(scene.objects[0].model->shapes.size(), 1u);
  const Shape& shape = scene.objects[0].model->shapes[0].shape;
  ASSERT_EQ(KindOf(shape), ShapeKind::kCylinder);
  EXPECT_NEAR(std::get<Cylinder>(shape).length_m, kHeight_m, 0.003);
}

}  // namespace
}  // namespace cwm::perception
