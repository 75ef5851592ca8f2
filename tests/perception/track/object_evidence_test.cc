#include "perception/track/object_evidence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "perception/track/ray_classification.h"
#include "tests/perception/track/head_on.h"

namespace cwm::perception {
namespace {

using ::testing::SizeIs;

const Vector3 kCube_m(0.2, 0.2, 0.1);  // its front is 1.3 m away
const HeadOnBox kMiddleBox{{0, 0, 1.35}, kCube_m};

TEST(ObjectEvidence, FitsTheSameBoxInItsPlaceAndWhereverItIsPut) {
  const HeadOnScan scan({kMiddleBox});
  const SceneInterpretation scene = scan.Scene();
  const HeadOnBox far{{-0.9, 0, 1.35}, kCube_m};
  const std::vector<KnownObject> known = {KnownBox("here", kMiddleBox), KnownBox("far", far)};
  const ObjectEvidence evidence(known, scene, scan.evidence());
  ASSERT_THAT(evidence.known, SizeIs(2));
  ASSERT_THAT(evidence.detected, SizeIs(1));
  EXPECT_DOUBLE_EQ(evidence.detected[0].own_share, 1);
  const PlacedFit* here = evidence.FitInPlace(0, 0);
  ASSERT_NE(here, nullptr);
  EXPECT_EQ(evidence.FitInPlace(1, 0), nullptr);
  const PlacedFit put = evidence.FitAt(1, evidence.detected[0].X_LO, 0);
  for (const PlacedFit& fit : {*here, put}) {
    EXPECT_DOUBLE_EQ(fit.explained_share, 1);
    EXPECT_GT(fit.covered_share, 0.95);
    EXPECT_DOUBLE_EQ(fit.through_share, 0);
    EXPECT_TRUE(evidence.IsAsGoodAsDetected(fit, 0));
  }
  EXPECT_NEAR(evidence.LargestShift_m(1, evidence.detected[0].X_LO), 0.9, 1e-9);
  EXPECT_NEAR(evidence.LargestShift_m(0, evidence.known[0].X_LO), 0, 1e-9);
  // 15 cm nearer to the sensor, the box ends in front of the points, and rays pass through it.
  const Pose nearer = MakeTranslation(0, 0, -0.15) * evidence.known[0].X_LO;
  const PlacedFit moved = evidence.FitAt(0, nearer, 0);
  EXPECT_DOUBLE_EQ(moved.explained_share, 0);
  EXPECT_DOUBLE_EQ(moved.through_share, 1);
  EXPECT_FALSE(evidence.IsAsGoodAsDetected(moved, 0));
}

// One detection covers the fronts of two boxes side by side.
TEST(ObjectEvidence, TellsWhatUsersAndWhatStandsExplainOfADetection) {
  const HeadOnBox left{{-0.1, 0, 1.35}, kCube_m}, right{{0.1, 0, 1.35}, kCube_m};
  const HeadOnScan scan({{{0, 0, 1.35}, {0.4, 0.2, 0.1}}});
  const SceneInterpretation scene = scan.Scene();
  KnownObject users = KnownBox("user's", left);
  users.owned_by_user = true;
  // A user's box explains points within 10 mm beyond its edge: 21 of 40 cm.
  const std::vector<KnownObject> alone = {users};
  const ObjectEvidence one(alone, scene, scan.evidence());
  EXPECT_THAT(one.known, SizeIs(0));
  EXPECT_NEAR(one.UserShare(0), 0.525, 0.02);
  EXPECT_DOUBLE_EQ(one.PresentShare(0), one.UserShare(0));
  const std::vector<KnownObject> both = {users, KnownBox("other", right)};
  const ObjectEvidence two(both, scene, scan.evidence());
  ASSERT_THAT(two.known, SizeIs(1));
  EXPECT_EQ(two.known[0].index, 1);
  EXPECT_DOUBLE_EQ(two.UserShare(0), one.UserShare(0));
  EXPECT_DOUBLE_EQ(two.PresentShare(0), 1);
}

// Leftover points of a known support are residual geometry, but a flat object on it is not.
TEST(ObjectEvidence, LetsKnownSupportsExplainResidualGeometryAlone) {
  const HeadOnScan scan({kMiddleBox});
  SceneInterpretation scene = scan.Scene();
  KnownObject support = KnownBox("support", kMiddleBox);
  support.kind = KnownObject::Kind::kSupport;
  const std::vector<KnownObject> known = {support};
  const ObjectEvidence as_object(known, scene, scan.evidence());
  EXPECT_THAT(as_object.known, SizeIs(0));
  EXPECT_DOUBLE_EQ(as_object.PresentShare(0), 0);
  scene.objects[0].kind = DetectedKind::kResidual;
  const ObjectEvidence as_residual(known, scene, scan.evidence());
  EXPECT_DOUBLE_EQ(as_residual.PresentShare(0), 1);
  EXPECT_DOUBLE_EQ(as_residual.UserShare(0), 0);
}

// A tray whose wide floor lay 9 mm in front of a wall, with a box in its middle, is gone. Only the
// wall is left, and looks like the tray's floor.
TEST(ObjectEvidence, BelievesNoRaysThatEndOnASupport) {
  HybridModel tray;
  tray.shapes.push_back({.X_OS = MakeTranslation(0, 0, -0.004), .shape = Box{{0.4, 0.4, 0.01}}});
  tray.shapes.push_back({.X_OS = MakeTranslation(0, 0, -0.08), .shape = Box{{0.16, 0.16, 0.14}}});
  KnownObject known = KnownBox("tray", {{0, 0, kWallDepth_m}, kCube_m});
  known.model = std::make_shared<const HybridModel>(std::move(tray));
  const std::vector<KnownObject> all = {known};
  const HeadOnScan scan({});
  SceneInterpretation scene = scan.Scene();
  const ObjectEvidence misled(all, scene, scan.evidence());
  EXPECT_GT(misled.known[0].sights.hit, misled.known[0].sights.through);
  EXPECT_EQ(ClassifyByRays(misled.known[0].sights), Association::Outcome::kKeep);

  HybridModel wall;
  wall.shapes.push_back(
      {.shape =
           Plate{.outline = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}, .holes = {}, .thickness_m = 0.02},
       .fit = {}});
  scene.supports.push_back({.X_WO = known.X_WO,
                            .model = std::make_shared<const HybridModel>(std::move(wall)),
                            .reachable = {}});
  const ObjectEvidence evidence(all, scene, scan.evidence());
  EXPECT_EQ(evidence.known[0].sights.hit, 0);
  EXPECT_DOUBLE_EQ(evidence.known[0].sights.ThroughShare(), 1);
  EXPECT_EQ(ClassifyByRays(evidence.known[0].sights), Association::Outcome::kRemove);
}

}  // namespace
}  // namespace cwm::perception
