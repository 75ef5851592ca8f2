// Patches of a support that are cut off from the rest of it by objects in front of them or by a
// wall.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct Points {
  int objects = 0, supports = 0;
};

// The points of each object on a support, by the object's index.
std::map<std::uint32_t, Points> PointsOfObjects(SceneFamily family, std::uint64_t seed) {
  const SimulatedView view = RandomScene(family, seed);
  const SimulatedCloud scan = Scan(view.scene, view.camera, {.seed = seed});
  InterpretOptions options;
  options.X_WC = view.camera.X_WC;
  const auto found = InterpretScene(scan.cloud, options);
  EXPECT_TRUE(found.ok()) << found.status();
  std::map<std::uint32_t, Points> of_object;
  if (!found.ok()) return of_object;
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    if (scan.object[i] < 0 || found->labels[i] < 20) continue;
    const std::uint32_t object = found->labels[i] / 10 - 2;
    if (found->objects[object].kind != DetectedKind::kObject) continue;
    const bool is_support = view.scene.objects[static_cast<std::size_t>(scan.object[i])].is_support;
    ++(is_support ? of_object[object].supports : of_object[object].objects);
  }
  EXPECT_FALSE(of_object.empty());
  return of_object;
}

class PatchOfTheCounter : public ::testing::TestWithParam<std::uint64_t> {};

// The floor of a pan and the patch behind its handle lie nearly on the counter's plane, and the
// pan's wall between them hides that they are separate.
TEST_P(PatchOfTheCounter, IsNoPartOfAnObject) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kKitchen, GetParam())) {
    EXPECT_LT(points.supports, 100 + points.objects / 20) << "object " << object + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PatchOfTheCounter, ::testing::Values(1002, 1014, 1050, 1062));

class PatchBetweenObjects : public ::testing::TestWithParam<std::uint64_t> {};

// A strip of the table between two shadows lies on the table's plane; the table between is hidden.
TEST_P(PatchBetweenObjects, IsNoObject) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kClutter, GetParam())) {
    EXPECT_LE(points.supports, points.objects) << "object " << object + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PatchBetweenObjects, ::testing::Values(2043, 2044, 2060, 2075));

// A patch of the support and a scrap of residual beside it do not become an object together.
TEST(PatchBesideAScrap, IsNoObjectWithAScrap) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kKitchen, 1033)) {
    EXPECT_LT(points.supports, 200 + points.objects) << "object " << object + 1;
  }
}

}  // namespace
}  // namespace cwm::perception
