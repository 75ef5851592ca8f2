// Twins by their size, whatever their frames.
#include "perception/live/shape_signature.h"

#include <gtest/gtest.h>

namespace cwm::perception {
namespace {

HybridModel ModelOf(const Pose& X_OS, const Shape& shape) {
  HybridModel model;
  model.shapes.push_back({.X_OS = X_OS, .shape = shape});
  return model;
}

TEST(ShapeSignature, HasTheExtentsOfASphereAlongAllAxes) {
  // The variance of a sphere's surface is r^2 / 3 along each axis, which is that of an edge of 2 r.
  const ShapeSignature ball(ModelOf(MakeTranslation(0.1, 0, 0.2), Sphere{.radius_m = 0.05}));
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(ball.extents_m()[i], 0.1, 0.005);
}

TEST(ShapeSignature, DoesNotDependOnTheFrame) {
  const Shape can = Cylinder{.radius_m = 0.033, .length_m = 0.12};
  const Pose X_OS = MakePose({0.02, -0.01, 0.3},
                             Quaternion(Eigen::AngleAxisd(1.1, Vector3(1, 2, 3).normalized())));
  EXPECT_TRUE(
      ShapeSignature(ModelOf(Pose::Identity(), can)).IsAlike(ShapeSignature(ModelOf(X_OS, can))));
}

TEST(ShapeSignature, TellsSizesApartBeyondTheirErrors) {
  const ShapeSignature can(
      ModelOf(Pose::Identity(), Cylinder{.radius_m = 0.033, .length_m = 0.12}));
  const ShapeSignature measured(
      ModelOf(Pose::Identity(), Cylinder{.radius_m = 0.0345, .length_m = 0.116}));
  const ShapeSignature wider(
      ModelOf(Pose::Identity(), Cylinder{.radius_m = 0.045, .length_m = 0.12}));
  const ShapeSignature box(ModelOf(Pose::Identity(), Box{{0.05, 0.09, 0.12}}));
  EXPECT_TRUE(can.IsAlike(measured));
  EXPECT_FALSE(can.IsAlike(wider));
  EXPECT_FALSE(can.IsAlike(box));
}

}  // namespace
}  // namespace cwm::perception
