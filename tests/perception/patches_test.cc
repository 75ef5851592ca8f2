// Patches of a support that what stands before them, or a wall, cuts off from the rest of it.
#include <gtest/gtest.h>

#include <cstdint>
#include <map>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct Points {
  int things = 0, supports = 0;
};

// Of each object on a support, by its index.
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
    ++(is_support ? of_object[object].supports : of_object[object].things);
  }
  EXPECT_FALSE(of_object.empty());
  return of_object;
}

class PatchOfTheCounter : public ::testing::TestWithParam<std::uint64_t> {};

// The floor of a pan lies nearly on the counter's plane, as does the patch behind its handle, and the
// pan's wall between them hides that they are two.
TEST_P(PatchOfTheCounter, IsNoPartOfAThing) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kKitchen, GetParam())) {
    EXPECT_LT(points.supports, 100 + points.things / 20) << "object " << object + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PatchOfTheCounter, ::testing::Values(1002, 1014, 1050, 1062));

class PatchBetweenThings : public ::testing::TestWithParam<std::uint64_t> {};

// A strip of the table between two shadows lies on its plane, and what is between is hidden.
TEST_P(PatchBetweenThings, IsNoThing) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kClutter, GetParam())) {
    EXPECT_LE(points.supports, points.things) << "object " << object + 1;
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, PatchBetweenThings, ::testing::Values(2043, 2044, 2060, 2075));

// A scrap beside a patch belongs to no thing, and the patch to no scrap.
TEST(PatchBesideAScrap, IsNoThingWithAScrap) {
  for (const auto& [object, points] : PointsOfObjects(SceneFamily::kKitchen, 1033)) {
    EXPECT_LT(points.supports, 200 + points.things) << "object " << object + 1;
  }
}

}  // namespace
}  // namespace cwm::perception
