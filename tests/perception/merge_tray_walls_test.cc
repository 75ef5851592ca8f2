#include "perception/refinement/merge/merge_tray_walls.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <string>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/tolerances.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/virtual_scanner.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

constexpr double kWall_m = 0.004;
// For two sides each: the 5 mm of thickness given to a lone face, and as much again for the
// uncertainty of where a wall ends.
constexpr double kWithin_m = 0.02;

Pose Turned(double x_m, double y_m, double z_m, double yaw_rad) {
  Pose X = MakeTranslation(x_m, y_m, z_m);
  X.rotate(Eigen::AngleAxisd(yaw_rad, Vector3::UnitZ()));
  return X;
}

// An open cardboard box: its floor, part 0, and four sides.
SimulatedObject OpenBoxOf(const Vector3& size_m, double yaw_rad) {
  const Vector3 half = 0.5 * size_m;
  SimulatedObject box{.name = "box", .X_WO = Turned(0, 0, 0, yaw_rad)};
  box.parts = {{MakeTranslation(0, 0, 0.5 * kWall_m), Box{{size_m.x(), size_m.y(), kWall_m}}}};
  for (const double side : {-1.0, 1.0}) {
    box.parts.push_back({MakeTranslation(side * (half.x() - 0.5 * kWall_m), 0, half.z()),
                         Box{{kWall_m, size_m.y(), size_m.z()}}});
    box.parts.push_back({MakeTranslation(0, side * (half.y() - 0.5 * kWall_m), half.z()),
                         Box{{size_m.x(), kWall_m, size_m.z()}}});
  }
  return box;
}

struct Seen {
  SimulatedCloud scan;
  SceneInterpretation result;

  // The share of a true object's part whose points are labelled as detected object `detected`; -1
  // stands for any support.
  double Share(std::int32_t object, int part, std::int32_t detected) const {
    double all = 0, labelled = 0;
    for (std::size_t i = 0; i < scan.object.size(); ++i) {
      if (scan.object[i] != object || (part >= 0 && scan.part[i] != part)) continue;
      ++all;
      const std::uint32_t label = result.labels[i];
      labelled += detected < 0
                      ? label > 0 && label < 10
                      : label >= 20 && static_cast<std::int32_t>(label / 10) - 2 == detected;
    }
    return labelled / all;
  }

  std::ptrdiff_t objects() const {
    return std::ranges::count(result.objects, DetectedKind::kObject, &DetectedObject::kind);
  }
};

Seen SeenBySensor(const SimulatedScene& scene, std::uint64_t seed,
                  const ViewingDirection& view = {
                      .distance_m = 1, .down_rad = 45 * kDegree, .azimuth_rad = 0.3}) {
  PinholeCamera camera;
  camera.X_WC = LookAt(Vector3(0, 0, 0.03), view);
  Seen seen{.scan = Scan(scene, camera, {.seed = seed}), .result = {}};
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  auto result = InterpretScene(seen.scan.cloud, options);
  EXPECT_TRUE(result.ok());
  if (result.ok()) seen.result = *std::move(result);
  return seen;
}

// True if the place lies in no solid.
bool IsFree(const SceneInterpretation& scene, const Vector3& place) {
  return std::ranges::none_of(scene.objects, [&](const DetectedObject& object) {
    return std::ranges::any_of(object.model->shapes, [&](const ShapePart& part) {
      return SignedDistance_m(part, (object.X_WO * part.X_OS).inverse(Eigen::Isometry) * place) < 0;
    });
  });
}

class OpenBoxes : public ::testing::TestWithParam<int> {
 protected:
  std::uint64_t seed() const { return static_cast<std::uint64_t>(GetParam()); }
  double yaw_rad() const { return 13 * GetParam() * kDegree; }
};

// Expects one object of five boxes with its own floor and a free inside.
void ExpectOpenBox(const Seen& seen, const Vector3& size_m, double yaw_rad) {
  const DetectedObject& box = seen.result.objects.front();
  EXPECT_GE(seen.Share(1, -1, 0), 0.9);
  EXPECT_GE(seen.Share(1, 0, 0), 0.9) << "of its floor";
  EXPECT_EQ(box.model->shapes.size(), 5u);
  Aabb bounds;
  for (const ShapePart& part : box.model->shapes) {
    bounds.extend(TightBounds(part.shape, Turned(0, 0, 0, -yaw_rad) * box.X_WO * part.X_OS));
  }
  const Vector3 extent = bounds.sizes();
  EXPECT_LT((extent - size_m).cwiseAbs().maxCoeff(), kWithin_m) << extent.transpose();
  for (int k = 0; k < 27; ++k) {
    const int x = k % 3 - 1, y = k / 3 % 3 - 1, z = k / 9 + 1;
    const Vector3 share(x, y, z);
    const Vector3 place = share.cwiseProduct(Vector3(0.35, 0.35, 0.3).cwiseProduct(size_m));
    EXPECT_TRUE(IsFree(seen.result, Turned(0, 0, 0, yaw_rad) * place)) << place.transpose();
  }
}

TEST_P(OpenBoxes, TraysAreOneObjectWithTheirFloor) {
  const Vector3 size_m(0.38, 0.27, 0.04);
  const Seen seen = SeenBySensor({{Table(), OpenBoxOf(size_m, yaw_rad())}}, seed());
  ASSERT_EQ(seen.objects(), 1);
  ExpectOpenBox(seen, size_m, yaw_rad());
}

TEST_P(OpenBoxes, CartonsAreOneObjectWithAFreeInside) {
  const Vector3 size_m(0.3, 0.2, 0.14);
  const Seen seen = SeenBySensor({{Table(), OpenBoxOf(size_m, yaw_rad())}}, seed());
  ASSERT_EQ(seen.objects(), 1);
  ExpectOpenBox(seen, size_m, yaw_rad());
}

TEST_P(OpenBoxes, CarryWhatLiesInThem) {
  const Pose X_WO = Turned(0, 0, 0, yaw_rad());
  SimulatedScene scene{{Table(), OpenBoxOf({0.4, 0.28, 0.04}, yaw_rad())}};
  scene.objects.push_back(MakeObject("can", Cylinder{0.033, 0.11},
                                     X_WO * MakeTranslation(-0.1, 0.03, kWall_m + 0.055)));
  scene.objects.push_back(MakeObject("carton", Box{{0.06, 0.08, 0.07}},
                                     X_WO * MakeTranslation(0.1, -0.02, kWall_m + 0.035)));
  const Seen seen = SeenBySensor(scene, seed());
  ASSERT_EQ(seen.objects(), 3);
  EXPECT_GE(seen.Share(1, -1, 0), 0.9);
  for (std::int32_t k = 1; k < 3; ++k) {
    EXPECT_EQ(seen.result.objects[static_cast<std::size_t>(k)].rests_on, 0);
    EXPECT_GE(std::max(seen.Share(2, -1, k), seen.Share(3, -1, k)), 0.9);
  }
}

// Seen at so flat an angle that near and far walls are one object, the far walls lie where a closed
// box's hidden faces would be.
TEST_P(OpenBoxes, AreNotFilledWhereTheirFloorIsHidden) {
  const Vector3 size_m(0.34, 0.165, 0.175);
  for (const double more_deg : {0, 4, 8}) {
    const double turned_rad = yaw_rad() + more_deg * kDegree;
    SCOPED_TRACE(turned_rad);
    const Seen seen =
        SeenBySensor({{Table(), OpenBoxOf(size_m, turned_rad)}}, seed(),
                     {.distance_m = 1.2, .down_rad = 31 * kDegree, .azimuth_rad = 0.3});
    ASSERT_GE(seen.objects(), 1);
    for (const double height_m : {0.1, 0.13, 0.16}) {
      EXPECT_TRUE(IsFree(seen.result, {0, 0, height_m})) << height_m;
    }
  }
}

// Solid objects around a free place do not make an open box, because they fill the ground they
// stand on.
TEST_P(OpenBoxes, AreNotMadeOfSolidsAroundAPlace) {
  SimulatedScene scene{{Table()}};
  for (int k = 0; k < 4; ++k) {
    const Pose X_WO = Turned(0, 0, 0, yaw_rad() + k * 90 * kDegree);
    scene.objects.push_back(MakeObject("side" + std::to_string(k), Box{{0.05, 0.19, 0.06}},
                                       X_WO * MakeTranslation(0.125, 0, 0.03)));
  }
  const Seen seen = SeenBySensor(scene, seed());
  std::size_t inside = 0, of_support = 0;
  for (std::size_t i = 0; i < seen.scan.object.size(); ++i) {
    const Vector3 p = seen.result.X_WC * seen.scan.cloud.points[i].cast<double>();
    if (seen.scan.object[i] != 0 || !(p.head<2>().norm() < 0.06)) continue;
    ++inside;
    of_support += seen.result.labels[i] == 1;
  }
  ASSERT_GT(inside, 500u);
  EXPECT_GE(of_support, inside - inside / 50);
}

INSTANTIATE_TEST_SUITE_P(Seeds, OpenBoxes, ::testing::Range(0, 7));

}  // namespace
}  // namespace cwm::perception
