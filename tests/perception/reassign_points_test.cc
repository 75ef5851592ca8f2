#include "perception/refinement/reassign/reassign_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "perception/simulation/vessels.h"
#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

// A mug whose handle points towards an angle about z.
SimulatedObject Mug(std::uint64_t seed, double y_m, double handle_deg) {
  RandomDraws draws(seed, 0);
  SimulatedObject mug = DrawVessel(VesselKind::kMug, draws);
  mug.X_WO = MakeTranslation(0, y_m, 0);
  mug.X_WO.rotate(Eigen::AngleAxisd(handle_deg * kDegree_rad, Vector3::UnitZ()));
  return mug;
}

double Radius_m(const SimulatedObject& mug) {
  return 0.5 * TightBounds(mug.parts[0].shape, mug.parts[0].X_FS).sizes().x();
}

double Reach_m(const SimulatedObject& mug) {
  return TightBounds(mug.parts[1].shape, mug.parts[1].X_FS).max().x();
}

// Expects one mug on either side of y = 0, each with its handle.
void ExpectTwoMugs(const SceneInterpretation& scene) {
  ASSERT_EQ(std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind), 2);
  for (std::size_t k = 0; k < 2; ++k) {
    const HybridModel& model = *scene.objects[k].model;
    ASSERT_EQ(model.shapes.size(), 1u) << k;
    EXPECT_TRUE(model.shapes.front().vessel) << k;
    EXPECT_EQ(model.handles.size(), 1u) << k;
  }
  EXPECT_LT(scene.objects[0].X_WO.translation().y() * scene.objects[1].X_WO.translation().y(), 0);
}

TEST(MugsThatTouch, AreTwoWithAHandleEach) {
  for (const std::uint64_t seed : {1, 2, 3, 6}) {
    SCOPED_TRACE(seed);
    SimulatedObject right = Mug(seed, 0, -110), left = Mug(seed + 100, 0, 110);
    right.X_WO.pretranslate(Vector3(0, -Radius_m(right), 0));
    left.X_WO.pretranslate(Vector3(0, Radius_m(left) + 0.001, 0));
    ExpectTwoMugs(Interpreted({{Table(), right, left}}));
  }
}

TEST(AHandleThatTouchesAMug, IsItsOwnMugs) {
  for (const std::uint64_t seed : {1, 2, 3, 6}) {
    SCOPED_TRACE(seed);
    SimulatedObject right = Mug(seed, 0, 90), left = Mug(seed + 100, 0, 110);
    right.X_WO.pretranslate(Vector3(0, -Reach_m(right), 0));
    left.X_WO.pretranslate(Vector3(0, Radius_m(left) + 0.001, 0));
    ExpectTwoMugs(Interpreted({{Table(), right, left}}));
  }
}

}  // namespace
}  // namespace cwm::perception
