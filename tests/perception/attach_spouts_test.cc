#include "perception/refinement/attach/attach_spouts.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "perception/simulation/vessels.h"
#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

std::ptrdiff_t CountObjects(const SceneInterpretation& scene) {
  return std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind);
}

// A jug with its handle towards x and its spout towards -x, turned by `yaw_deg`.
SimulatedObject Jug(std::uint64_t seed, double yaw_deg) {
  RandomDraws draws(seed, 0);
  SimulatedObject jug = DrawVessel(VesselKind::kJug, draws);
  jug.X_WO.rotate(Eigen::AngleAxisd(yaw_deg * kDegree_rad, Vector3::UnitZ()));
  return jug;
}

// The camera looks along x. Where the jug hides its own spout, the spout cannot be told from an
// object behind the jug.
class Spout : public ::testing::TestWithParam<double> {};

TEST_P(Spout, IsAPartOfItsJugAndNoHandle) {
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const SimulatedObject jug = Jug(seed, GetParam());
    const SceneInterpretation scene = Interpreted({{Table(), jug}});
    EXPECT_EQ(CountObjects(scene), 1) << seed;
    ASSERT_FALSE(scene.objects.empty()) << seed;
    // No handle is centred on the spout's side of the jug.
    for (const Handle& handle : scene.objects.front().model->handles) {
      const Vector3 middle =
          jug.X_WO.inverse() * scene.objects.front().X_WO * handle.bounds.X_FS.translation();
      EXPECT_GT(middle.x(), 0) << seed;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Yaws_deg, Spout, ::testing::Values(0, 40, 80, -40, -80));

// The bottle stands in the jug's shadow: its foot and everything below its visible top are hidden.
TEST(WhatStandsBehindAJug, StaysAnObject) {
  SimulatedObject jug = Jug(1, 90);
  jug.parts.pop_back();  // the spout
  jug.part_roles.pop_back();
  const SimulatedObject bottle =
      MakeObject("bottle", Cylinder{0.02, 0.26}, MakeTranslation(0.1, 0, 0.13));
  EXPECT_EQ(CountObjects(Interpreted({{Table(), jug, bottle}})), 2);
}

}  // namespace
}  // namespace cwm::perception
