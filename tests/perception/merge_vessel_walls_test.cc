// Vessels that lie on a table and that segmentation splits become one object with one shell.
#include "perception/refinement/merge/merge_vessel_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <vector>

#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

struct Lying {
  std::string name;
  VesselWall wall;
  double tilt_deg = 0, yaw_deg = 0;
};

void PrintTo(const Lying& lying, std::ostream* out) { *out << lying.name; }

class MergeLyingVessels : public ::testing::TestWithParam<Lying> {};

const DetectedObject* Largest(const SceneInterpretation& scene) {
  const auto by_points = [](const DetectedObject& a, const DetectedObject& b) {
    return a.model->point_count < b.model->point_count;
  };
  const auto largest = std::ranges::max_element(scene.objects, by_points);
  return largest == scene.objects.end() ? nullptr : &*largest;
}

TEST_P(MergeLyingVessels, MakesThemOneShell) {
  const Lying& lying = GetParam();
  const SimulatedObject truth = TiltedVessel(lying.wall, lying.tilt_deg, lying.yaw_deg);
  const SceneInterpretation scene = Interpreted({{Table(), truth}});
  EXPECT_EQ(std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind), 1);
  const DetectedObject* object = Largest(scene);
  ASSERT_NE(object, nullptr);
  ASSERT_EQ(object->model->shapes.size(), 1u);
  const ShapePart& part = object->model->shapes[0];
  ASSERT_TRUE(part.vessel);
  EXPECT_NEAR(part.vessel->rim_radius_m(), lying.wall.outer.back().radius_m, 0.003);
  EXPECT_NEAR(part.vessel->height_m(), lying.wall.outer.back().height_m, 0.006);
  EXPECT_LT(
      AngleBetween_deg((object->X_WO * part.X_OS).linear().col(2), truth.X_WO.linear().col(2)), 3);
}

INSTANTIATE_TEST_SUITE_P(All, MergeLyingVessels,
                         ::testing::Values(Lying{"LeaningMug", MugWall(), 40, 150},
                                           Lying{"MugOnItsSide", MugWall(), 90, 180},
                                           Lying{"LeaningPan", PanWall(), 70, 180},
                                           Lying{"PanOnEdge", PanWall(), 90, 150},
                                           Lying{"LeaningGlass", GlassWall(), 70, 120},
                                           Lying{"LeaningBowl", BowlWall(), 70, 150}),
                         [](const auto& named) { return named.param.name; });

TEST(LyingVessels, KeepTheirHandles) {
  SimulatedObject mug = TiltedVessel(MugWall(), 90, 150);
  std::vector<TubePoint> bow;
  for (int k = 0; k <= 16; ++k) {
    const double turn_rad = 180 * kDegree_rad * (k / 16.0 - 0.5);
    bow.push_back(
        {.place_xz = {-0.036 - 0.035 * std::cos(turn_rad), 0.05 + 0.03 * std::sin(turn_rad)},
         .half_thickness_m = 0.005,
         .half_width_m = 0.006});
  }
  mug.parts.push_back({.shape = MakeMesh(MakeTube(bow))});
  const SceneInterpretation scene = Interpreted({{Table(), mug}});
  const DetectedObject* object = Largest(scene);
  ASSERT_NE(object, nullptr);
  ASSERT_EQ(object->model->shapes.size(), 1u);
  EXPECT_TRUE(object->model->shapes[0].vessel);
  EXPECT_EQ(object->model->handles.size(), 1u);
}

// Boxes and a can that touch stay three objects.
TEST(LyingVessels, LeavesWhatIsNoVesselApart) {
  const SceneInterpretation scene = Interpreted(
      {{Table(), MakeObject("box", Box{{0.1, 0.14, 0.16}}, MakeTranslation(0.05, -0.12, 0.08)),
        MakeObject("can", Cylinder{0.05, 0.12}, MakeTranslation(0, 0, 0.06)),
        MakeObject("low box", Box{{0.12, 0.1, 0.06}}, MakeTranslation(-0.02, 0.1, 0.03))}});
  EXPECT_EQ(std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind), 3);
  for (const DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) EXPECT_FALSE(part.vessel);
  }
}

}  // namespace
}  // namespace cwm::perception
