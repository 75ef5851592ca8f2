#include "perception/hidden_depth.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collision/geometry/signed_distance.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

// derived: the pitch of TableCamera, by which a box turns one face to it.
constexpr double kPitch_rad = 35 * kDegree;
constexpr double kSize_m = 0.15;

// The shape parts of all objects, in the world's frame.
struct WorldPart {
  Pose X_WO;
  ShapePart part;
};

std::vector<WorldPart> PartsOf(const SceneInterpretation& scene) {
  std::vector<WorldPart> parts;
  for (const DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) parts.push_back({object.X_WO, part});
  }
  return parts;
}

bool Hides(const WorldPart& part, const Vector3& p_W) {
  if (!part.part.hidden) return false;
  const Pose X_WB = part.X_WO * part.part.hidden->X_FS;
  return SignedDistance_m(part.part.hidden->shape, X_WB.inverse(Eigen::Isometry) * p_W) < 0;
}

// A box that leans so that the camera sees its front face alone.
SimulatedScene BoxThatTurnsOneFaceToTheCamera() {
  Pose X_WO = MakeTranslation(0, 0, 0.5 * kSize_m * (std::sin(kPitch_rad) + std::cos(kPitch_rad)));
  X_WO.rotate(Eigen::AngleAxisd(kPitch_rad, Vector3::UnitY()));
  return {{Table(), MakeObject("box", Box{{kSize_m, kSize_m, kSize_m}}, X_WO)}};
}

TEST(HiddenDepth, ReachesThroughTheBodyBehindALoneFace) {
  const SimulatedScene made = BoxThatTurnsOneFaceToTheCamera();
  const Pose& X_WO = made.objects.back().X_WO;
  const std::vector<WorldPart> parts = PartsOf(Interpreted(made));
  const auto face = std::ranges::find_if(
      parts, [&](const WorldPart& part) { return Hides(part, X_WO.translation()); });
  ASSERT_NE(face, parts.end());
  EXPECT_EQ(face->part.role, PartRole::kCompleted);
  // The middle of the far side, and of each side near it.
  const double half_m = 0.5 * kSize_m, almost_m = 0.9 * half_m;
  for (const Vector3& p_O : {Vector3(almost_m, 0, 0), Vector3(almost_m, almost_m, 0),
                             Vector3(almost_m, -almost_m, 0), Vector3(almost_m, 0, almost_m)}) {
    EXPECT_TRUE(Hides(*face, X_WO * p_O)) << p_O.transpose();
  }
  // In front of the face everything is seen.
  EXPECT_FALSE(Hides(*face, X_WO * Vector3(-half_m - 0.02, 0, 0)));
  EXPECT_NEAR(HiddenDepth_m(face->part), 0.3, 0.25) << "the shadow ends on the table";
}

TEST(HiddenDepth, IsNoneOfABoxOfWhichTheTopAndTheFrontAreSeen) {
  for (const double yaw_deg : {0.0, 20.0, 45.0}) {
    Pose X_WO = MakeTranslation(0, 0, 0.5 * kSize_m);
    X_WO.rotate(Eigen::AngleAxisd(yaw_deg * kDegree, Vector3::UnitZ()));
    const std::vector<WorldPart> parts = PartsOf(
        Interpreted({{Table(), MakeObject("box", Box{{kSize_m, kSize_m, kSize_m}}, X_WO)}}));
    ASSERT_EQ(parts.size(), 1u) << yaw_deg;
    EXPECT_FALSE(parts.front().part.hidden) << yaw_deg;
    EXPECT_EQ(parts.front().part.role, PartRole::kFitted) << yaw_deg;
  }
}

TEST(HiddenDepth, IsNoneOfTwoBoxesThatHideEachOthersSides) {
  // In a row along the view: the far box is a little higher, and hides nothing but what is behind.
  const std::vector<WorldPart> parts = PartsOf(
      Interpreted({{Table(), MakeObject("near", Box{{0.1, 0.1, 0.1}}, MakeTranslation(0, 0, 0.05)),
                    MakeObject("far", Box{{0.1, 0.1, 0.14}}, MakeTranslation(0.101, 0, 0.07))}}));
  ASSERT_EQ(parts.size(), 2u);
  for (const WorldPart& part : parts) {
    EXPECT_FALSE(part.part.hidden) << part.part.hidden->shape.size_m.transpose();
  }
}

}  // namespace
}  // namespace cwm::perception
