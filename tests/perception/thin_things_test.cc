// Things of few millimetres on tables, and tables without any.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <map>
#include <numbers>

#include "perception/interpret_scene.h"
#include "perception/simulation/angles.h"
#include "perception/simulation/furniture.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/virtual_scanner.h"

// The test's own names are those of other tests of this target.
namespace cwm::perception::thin_things {
namespace {

constexpr double kTop_m = 0.72;

SimulatedScene Table() {
  SimulatedScene scene;
  scene.objects.push_back(
      MakeTop("floor", {.area_W = {Vector2(-3, -3), Vector2(3, 3)}, .top_m = 0}));
  scene.objects.push_back(
      MakeTop("table", {.area_W = {Vector2(-0.6, -0.4), Vector2(0.6, 0.4)}, .top_m = kTop_m}));
  return scene;
}

void Lay(const Vector3& size_m, double x_m, double y_m, double turned_deg, SimulatedScene& scene) {
  const Quaternion turned(Eigen::AngleAxisd(Radians(turned_deg), Vector3::UnitZ()));
  scene.objects.push_back({.name = "thin",
                           .parts = {{Pose::Identity(), Box{size_m}}},
                           .X_WO = MakePose({x_m, y_m, kTop_m + size_m.z() / 2}, turned)});
}

struct ThinScan {
  SimulatedCloud scan;
  SceneInterpretation found;
};

ThinScan Look(const SimulatedScene& scene, const SensorNoise& noise, std::uint64_t seed) {
  PinholeCamera camera;
  camera.X_WC = LookAt(Vector3(0, 0, kTop_m),
                       ViewingDirection{.distance_m = 0.9,
                                        .down_rad = Radians(45 + 3 * static_cast<double>(seed)),
                                        .azimuth_rad = 0.7 * static_cast<double>(seed)});
  ThinScan seen{.scan = Scan(scene, camera, {.noise = noise, .seed = seed}), .found = {}};
  InterpretOptions options;
  options.noise = noise;
  options.X_WC = camera.X_WC;
  auto found = InterpretScene(seen.scan.cloud, options);
  EXPECT_TRUE(found.ok()) << found.status();
  if (found.ok()) seen.found = *std::move(found);
  return seen;
}

// The object that most points of the scene's object k belong to, or -1.
int ObjectOf(const ThinScan& seen, std::int32_t k) {
  std::map<int, int> votes;
  for (std::size_t i = 0; i < seen.scan.object.size(); ++i) {
    if (seen.scan.object[i] == k) ++votes[static_cast<int>(seen.found.labels[i] / 10) - 2];
  }
  const auto most =
      std::ranges::max_element(votes, {}, [](const auto& vote) { return vote.second; });
  return most == votes.end() || most->first < 0 ? -1 : most->first;
}

const SensorNoise kStereo{
    .model = SensorModel::kGiven, .given_sigma_m = 5e-4, .given_quadratic_per_m = 8e-4};

TEST(ThinThings, APhoneAndABookAreObjectsThatFillTheirPlace) {
  SimulatedScene scene = Table();
  Lay({0.15, 0.075, 0.008}, -0.2, 0.05, 20, scene);
  Lay({0.21, 0.15, 0.015}, 0.15, 0, -35, scene);
  for (const SensorNoise& noise : {SensorNoise{}, kStereo}) {
    const ThinScan seen = Look(scene, noise, 1);
    for (const std::int32_t k : {2, 3}) {
      const int object = ObjectOf(seen, k);
      ASSERT_GE(object, 0) << "thing " << k;
      const DetectedObject& detected = seen.found.objects[static_cast<std::size_t>(object)];
      EXPECT_EQ(detected.kind, DetectedKind::kObject);
      EXPECT_EQ(detected.supported_by, 1);
      EXPECT_FALSE(detected.model->shapes.empty()) << "a solid, not only a surface";
    }
  }
}

TEST(ThinThings, WarpIsNoThing) {
  for (const SensorNoise& noise :
       {SensorNoise{}, SensorNoise{.model = SensorModel::kRealSense}, kStereo}) {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
      const ThinScan seen = Look(Table(), noise, seed);
      for (const DetectedObject& object : seen.found.objects) {
        EXPECT_NE(object.kind, DetectedKind::kObject) << "seed " << seed;
      }
    }
  }
}

}  // namespace
}  // namespace cwm::perception::thin_things
