#include "perception/refinement/split/split_stacked_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "collision/geometry/aabb.h"
#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

struct Layer {
  Vector3 size_m;
  double turned_deg = 0;
};

SimulatedScene Stack(const std::vector<Layer>& layers) {
  SimulatedScene scene{{Table()}};
  double foot_m = 0;
  for (const Layer& layer : layers) {
    Pose X_WO = MakeTranslation(0, 0, foot_m + 0.5 * layer.size_m.z());
    X_WO.rotate(Eigen::AngleAxisd(layer.turned_deg * kDegree_rad, Vector3::UnitZ()));
    scene.objects.push_back(
        MakeObject("layer" + std::to_string(scene.objects.size()), Box{layer.size_m}, X_WO));
    foot_m += layer.size_m.z();
  }
  return scene;
}

// Expects these layers from the lowest up: each an object between the heights of its own faces, on
// the one below.
void ExpectLayers(const SceneInterpretation& scene, const std::vector<Layer>& layers) {
  constexpr double kWithin_m = 0.006;
  ASSERT_EQ(std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind),
            static_cast<std::ptrdiff_t>(layers.size()));
  double foot_m = 0;
  std::int32_t below = -1;
  for (const Layer& layer : layers) {
    const double top_m = foot_m + layer.size_m.z();
    const auto is_it = [&](const DetectedObject& object) {
      if (object.model->shapes.empty()) return false;
      Aabb bounds;
      for (const ShapePart& part : object.model->shapes) {
        bounds.extend(TightBounds(part.shape, object.X_WO * part.X_OS));
      }
      return std::abs(bounds.min().z() - foot_m) < kWithin_m &&
             std::abs(bounds.max().z() - top_m) < kWithin_m;
    };
    const auto found = std::ranges::find_if(scene.objects, is_it);
    ASSERT_NE(found, scene.objects.end()) << "from " << foot_m << " to " << top_m;
    EXPECT_EQ(found->rests_on, below);
    below = static_cast<std::int32_t>(found - scene.objects.begin());
    foot_m = top_m;
  }
}

class TurnedBoxes : public ::testing::TestWithParam<double> {};
class TurnedBooks : public ::testing::TestWithParam<double> {};

TEST_P(TurnedBoxes, OnWideLowOnesAreOneEach) {
  for (const double turned_deg : {20.0, 30.0, 40.0}) {
    SCOPED_TRACE(turned_deg);
    const std::vector<Layer> layers{{{0.3, 0.22, 0.04}, GetParam()},
                                    {{0.16, 0.12, 0.1}, GetParam() + turned_deg}};
    ExpectLayers(Interpreted(Stack(layers)), layers);
  }
}

TEST_P(TurnedBooks, OnBooksAreOneEach) {
  const std::vector<Layer> layers{{{0.24, 0.18, 0.03}, GetParam()},
                                  {{0.22, 0.17, 0.025}, GetParam() + 20},
                                  {{0.2, 0.15, 0.035}, GetParam() - 5}};
  ExpectLayers(Interpreted(Stack(layers)), layers);
}

INSTANTIATE_TEST_SUITE_P(Yaws_deg, TurnedBoxes, ::testing::Values(0, 25, 50, 75));
INSTANTIATE_TEST_SUITE_P(Yaws_deg, TurnedBooks, ::testing::Values(0, 25, 50));

// The lower parts of both could also be one long box that carries the rest of the higher one.
TEST(BoxesSideBySide, AreNoStack) {
  const SceneInterpretation scene = Interpreted(
      {{Table(), MakeObject("low", Box{{0.12, 0.1, 0.06}}, MakeTranslation(0, -0.051, 0.03)),
        MakeObject("high", Box{{0.12, 0.1, 0.14}}, MakeTranslation(0, 0.051, 0.07))}});
  ASSERT_EQ(std::ranges::count(scene.objects, DetectedKind::kObject, &DetectedObject::kind), 2);
  for (const DetectedObject& object : scene.objects) EXPECT_EQ(object.rests_on, -1);
}

}  // namespace
}  // namespace cwm::perception
