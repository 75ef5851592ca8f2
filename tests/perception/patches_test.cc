// Patches of a counter that what stands before them, or a wall, cuts off from the rest of it.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

class PatchOfTheCounter : public ::testing::TestWithParam<std::uint64_t> {};

// The floor of a pan lies nearly on the counter's plane, as does the patch behind its handle, and the
// pan's wall between them hides that they are two.
TEST_P(PatchOfTheCounter, IsNoPartOfAThing) {
  const SimulatedView kitchen = RandomScene(SceneFamily::kKitchen, GetParam());
  const SimulatedCloud scan = Scan(kitchen.scene, kitchen.camera, {.seed = GetParam()});
  InterpretOptions options;
  options.X_WC = kitchen.camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  ASSERT_TRUE(found.ok()) << found.status();
  struct Points {
    int things = 0, supports = 0;
  };
  std::map<std::uint32_t, Points> of_object;
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    if (scan.object[i] < 0 || found->labels[i] < 20) continue;
    const bool is_support =
        kitchen.scene.objects[static_cast<std::size_t>(scan.object[i])].is_support;
    Points& points = of_object[found->labels[i] / 10 - 2];
    ++(is_support ? points.supports : points.things);
  }
  for (const auto& [object, points] : of_object) {
    if (found->objects[object].kind != DetectedKind::kObject) continue;
    EXPECT_LT(points.supports, 100 + points.things / 20) << "object " << object + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PatchOfTheCounter, ::testing::Values(1002, 1014, 1050, 1062));

}  // namespace
}  // namespace cwm::perception
