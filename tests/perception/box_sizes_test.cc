// How accurate the sizes of boxes are, and which sizes are unknown because an end is hidden.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

const Vector3 kSize_m(0.12, 0.08, 0.10);

// A table at z = 0 with one box on it.
SimulatedScene ObjectOnTable(const Vector3& size_m) {
  SimulatedScene scene;
  scene.objects.push_back({.name = "table",
                           .parts = {{.shape = Box{{1.2, 1.2, 0.04}}}},
                           .X_WO = MakeTranslation(0, 0, -0.02)});
  scene.objects.push_back({.name = "box",
                           .parts = {{.shape = Box{size_m}}},
                           .X_WO = MakeTranslation(0, 0, 0.5 * size_m.z())});
  scene.objects.back().X_WO.rotate(Eigen::AngleAxisd(0.2, Vector3::UnitZ()));
  return scene;
}

// A post hides the right half of the box if `hidden` is true.
SimulatedScene BoxOnTable(bool hidden) {
  SimulatedScene scene = ObjectOnTable(kSize_m);
  if (hidden) {
    scene.objects.push_back({.name = "post",
                             .parts = {{.shape = Box{{0.06, 0.10, 0.25}}}},
                             .X_WO = MakeTranslation(0.05, -0.22, 0.125)});
  }
  return scene;
}

constexpr double kNear_m = 0.9126335516;

// A camera that looks 35 degrees down at a place on the table, from this distance.
PinholeCamera InFront(double distance_m = kNear_m) {
  PinholeCamera camera;
  const Vector3 at(0, 0, 0.03);
  const Vector3 forward = (at - Vector3(0, -0.75, 0.55)).normalized();
  const Vector3 eye = at - distance_m * forward;
  const Vector3 right = Vector3::UnitX();
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = eye;
  return camera;
}

struct FoundBox {
  Vector3 size_m = Vector3::Zero();
  std::vector<double> sigma_m;
};

// The box found nearest to the middle of the true one; its size is 0 if none was found.
FoundBox Find(const SimulatedScene& scene, std::uint64_t seed,
              const PinholeCamera& camera = InFront()) {
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  const auto found = InterpretScene(Scan(scene, camera, {.seed = seed}).cloud, options);
  if (!found.ok()) return {};
  const Vector3 middle = scene.objects[1].X_WO.translation();
  for (const DetectedObject& object : found->objects) {
    for (const ShapePart& part : object.model->shapes) {
      const auto* box = std::get_if<Box>(&part.shape);
      if (box == nullptr || ((object.X_WO * part.X_OS).translation() - middle).norm() > 0.05) {
        continue;
      }
      return {box->size_m, part.fit ? part.fit->parameter_sigma : std::vector<double>()};
    }
  }
  return {};
}

TEST(BoxSizes, AreKnownToWhatTheyAreReportedWith) {
  int within = 0, sizes = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const FoundBox box = Find(BoxOnTable(false), seed);
    ASSERT_EQ(box.sigma_m.size(), 3U) << seed;
    for (std::size_t k = 0; k < 3; ++k) {
      const double error_m = std::abs(box.size_m(static_cast<Eigen::Index>(k)) -
                                      kSize_m(static_cast<Eigen::Index>(k)));
      EXPECT_GT(box.sigma_m[k], 0.0003) << seed;  // a face of thousands of points, and its warp
      EXPECT_LT(box.sigma_m[k], 0.004) << seed;
      EXPECT_LT(error_m, 4 * box.sigma_m[k]) << seed << " size " << k;
      within += error_m <= box.sigma_m[k];
      ++sizes;
    }
  }
  EXPECT_GE(within, sizes * 4 / 10);  // of 18 independent errors 12 on average, hardly ever below 8
}

TEST(BoxSizes, AreUnknownWhereAnEndIsHidden) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const FoundBox box = Find(BoxOnTable(true), seed);
    ASSERT_EQ(box.sigma_m.size(), 3U) << seed;
    EXPECT_EQ(box.sigma_m[0], 0) << seed << ": " << box.size_m.transpose();
    EXPECT_GT(box.sigma_m[2], 0) << seed;
  }
}

// A carton as thin as a book shows its front and a strip of its top that is narrower than the
// window in which normals are estimated. The strip gives no second face, but its points give the
// depth.
TEST(BoxSizes, AStripBehindAFaceTellsItsDepth) {
  constexpr double kDepth_m = 0.025;
  const Vector3 size_m(0.15, kDepth_m, 0.22);
  for (const double distance_m : {0.9, 1.1, 1.3}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const FoundBox box = Find(ObjectOnTable(size_m), seed, InFront(distance_m));
      ASSERT_GT(box.size_m.x(), 0) << distance_m << " m, seed " << seed;
      EXPECT_NEAR(box.size_m.minCoeff(), kDepth_m, 0.009) << distance_m << " m, seed " << seed;
      EXPECT_NEAR(box.size_m.maxCoeff(), size_m.z(), 0.006) << distance_m << " m, seed " << seed;
    }
  }
}

// Only the top of a large box is seen, and objects in front hide a third of it.
TEST(BoxSizes, AFaceThatSomethingHidesAPartOfIsABox) {
  constexpr std::size_t kBox = 9;  // index in the scene's objects
  const SimulatedView view = RandomScene(SceneFamily::kClutter, 1104);
  InterpretOptions options;
  options.X_WC = view.camera.X_WC;
  const auto found = InterpretScene(Scan(view.scene, view.camera, {.seed = 1104}).cloud, options);
  ASSERT_TRUE(found.ok()) << found.status();
  const Shape& shape = found->objects[0].model->shapes[0].shape;  // the largest
  const auto* box = std::get_if<Box>(&shape);
  ASSERT_NE(box, nullptr);
  const Vector3& true_m = std::get<Box>(view.scene.objects[kBox].parts[0].shape).size_m;
  const auto [shorter_m, longer_m] = std::minmax(box->size_m.x(), box->size_m.y());
  EXPECT_NEAR(shorter_m, std::min(true_m.x(), true_m.y()), 0.006);
  EXPECT_NEAR(longer_m, std::max(true_m.x(), true_m.y()), 0.006);
  EXPECT_EQ(found->objects[0].model->shapes[0].role, PartRole::kCompleted);
}

}  // namespace
}  // namespace cwm::perception
