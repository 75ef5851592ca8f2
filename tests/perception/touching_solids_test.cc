// The parts of objects that an occluder leaves visible beside other objects, seen by the virtual
// scanner.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct Seen {
  SimulatedView truth;
  SimulatedCloud scan;
  SceneInterpretation found;

  // The found object that has most of the points of a true one.
  const DetectedObject& Of(std::size_t object) const {
    std::map<std::uint32_t, int> count;
    for (std::size_t i = 0; i < scan.object.size(); ++i) {
      if (scan.object[i] == static_cast<std::int32_t>(object)) ++count[found.labels[i] / 10];
    }
    const auto most_frequent =
        std::ranges::max_element(count, {}, [](const auto& c) { return c.second; });
    return found.objects.at(most_frequent->first -
                            2);  // labels of objects[k] begin at 10 * (k + 2)
  }
};

Seen See(SceneFamily family, std::uint64_t seed) {
  Seen seen;
  seen.truth = RandomScene(family, seed);
  seen.scan = Scan(seen.truth.scene, seen.truth.camera, {.seed = seed});
  InterpretOptions options;
  options.X_WC = seen.truth.camera.X_WC;
  auto found = InterpretScene(seen.scan.cloud, options);
  EXPECT_TRUE(found.ok()) << found.status();
  if (found.ok()) seen.found = *std::move(found);
  return seen;
}

// Something hides all of the ball except a crescent that begins at a larger ball.
TEST(TouchingSolids, ABallBesideABallIsAnObject) {
  constexpr std::size_t kSmall = 5, kLarge = 6;
  const Seen seen = See(SceneFamily::kClutter, 38);
  const DetectedObject &small = seen.Of(kSmall), &large = seen.Of(kLarge);
  ASSERT_NE(&small, &large);
  ASSERT_EQ(small.model->shapes.size(), 1u);
  const auto* ball = std::get_if<Sphere>(&small.model->shapes.front().shape);
  ASSERT_NE(ball, nullptr);
  const auto& truth = std::get<Sphere>(seen.truth.scene.objects[kSmall].parts.front().shape);
  EXPECT_NEAR(ball->radius_m, truth.radius_m, 0.003);
  EXPECT_TRUE(large.model->handles.empty());
  for (std::size_t k = 1; k < seen.found.objects.size(); ++k) {
    const DetectedObject &before = seen.found.objects[k - 1], &object = seen.found.objects[k];
    if (object.supported_by < 0) break;
    EXPECT_GE(before.model->point_count, object.model->point_count) << k;
  }
}

// Mugs, pans and jugs keep their handles.
TEST(TouchingSolids, LeavesHandlesOfVesselsAlone) {
  int with_handle = 0;
  for (std::uint64_t seed = 2; seed < 10; seed += 2) {
    const Seen seen = See(SceneFamily::kVessels, seed);
    for (const DetectedObject& object : seen.found.objects) {
      with_handle += !object.model->handles.empty();
    }
  }
  EXPECT_GE(with_handle, 8);
}

// A box of the same size and tilt fits the cylinder's few points equally well, apart from their
// noise.
TEST(TouchingSolids, ALeaningCylinderIsNoTiltedBox) {
  constexpr std::size_t kLeaning = 7;
  for (const std::uint64_t seed : {7120U, 7222U}) {
    const Seen seen = See(SceneFamily::kTable, seed);
    const DetectedObject& leaning = seen.Of(kLeaning);
    ASSERT_EQ(leaning.model->shapes.size(), 1u) << seed;
    const auto* cylinder = std::get_if<Cylinder>(&leaning.model->shapes.front().shape);
    ASSERT_NE(cylinder, nullptr) << seed;
    const auto& truth = std::get<Cylinder>(seen.truth.scene.objects[kLeaning].parts.front().shape);
    EXPECT_NEAR(cylinder->radius_m, truth.radius_m, 0.003) << seed;
    EXPECT_NEAR(cylinder->length_m, truth.length_m, 0.01) << seed;
  }
}

// A lying cylinder hides the foot of one that leans beside it and seems to rest on it.
TEST(ModelObject, StandsOnTheSupportWhereThatExplainsItBetter) {
  constexpr std::size_t kLeaning = 8;
  const Seen seen = See(SceneFamily::kClutter, 35);
  const DetectedObject& leaning = seen.Of(kLeaning);
  ASSERT_EQ(leaning.model->shapes.size(), 1u);
  EXPECT_TRUE(std::holds_alternative<Cylinder>(leaning.model->shapes.front().shape));
  EXPECT_EQ(leaning.rests_on, -1);
  EXPECT_GE(leaning.supported_by, 0);
}

}  // namespace
}  // namespace cwm::perception
