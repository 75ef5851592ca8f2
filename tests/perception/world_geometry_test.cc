// The pipeline's treatment of walls, hidden parts, clutter and the borders of supports.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "collision/geometry/signed_distance.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/interpret_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

PinholeCamera LookingAlong(const Vector3& forward_W, const Vector3& from_W) {
  PinholeCamera camera;
  const Vector3 forward = forward_W.normalized(), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = from_W;
  return camera;
}

SceneInterpretation Interpreted(const SimulatedScene& scene, const PinholeCamera& camera,
                                Clustering clustering = Clustering::kObjects) {
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  options.clustering = clustering;
  auto interpreted = InterpretScene(Scan(scene, camera, {}).cloud, options);
  EXPECT_TRUE(interpreted.ok()) << interpreted.status();
  return interpreted.ok() ? *std::move(interpreted) : SceneInterpretation();
}

// The distance of the place from the nearest solid or surface; negative inside a solid.
double Clearance_m(const SceneInterpretation& scene, const Vector3& p_W) {
  double clearance_m = std::numeric_limits<double>::infinity();
  for (const DetectedObject& object : scene.objects) {
    const Vector3 p_O = object.X_WO.inverse() * p_W;
    for (const ShapePart& part : object.model->shapes) {
      clearance_m = std::min(clearance_m, SignedDistance_m(part.shape, part.X_OS.inverse() * p_O));
    }
    for (const SurfacePart& part : object.model->surfaces) {
      clearance_m = std::min(clearance_m, SignedDistance_m(part.surface, p_O));
    }
  }
  return clearance_m;
}

// An upright wall at x = 0, 2 m wide and high, seen from x < 0, with a window of 0.6 m in its
// middle.
SimulatedObject WallWithWindow() {
  const auto rectangle = [](double u, double low, double high) {
    return Polygon{{-u, low}, {u, low}, {u, high}, {-u, high}};
  };
  Polygon window = rectangle(0.3, -0.3, 0.3);
  std::reverse(window.begin(), window.end());
  SimulatedObject wall{.name = "wall",
                       .parts = {{.shape = Plate{rectangle(1, -1, 1), {window}, 0.05}}}};
  wall.X_WO.linear() << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  wall.X_WO.translation() = Vector3(0, 0, 1);
  return wall;
}

TEST(InterpretScene, LeavesTheWindowOfAWallOpen) {
  const SimulatedObject behind{.name = "behind",
                               .parts = {{.shape = Box{{0.05, 4, 4}}}},
                               .X_WO = MakeTranslation(1.2, 0, 1)};
  const SceneInterpretation scene =
      Interpreted({{WallWithWindow(), behind}}, LookingAlong({1, 0, 0}, {-1.5, 0, 1}));
  // The wall has a solid part; the window is free, up to two cells of four sigma at 1.5 m plus the
  // blur of mixed pixels.
  constexpr double kOutline_m = 0.04;
  for (const double sign : {-1.0, 1.0}) {
    EXPECT_LT(Clearance_m(scene, {0.01, sign * 0.5, 1}), 0);
    EXPECT_LT(Clearance_m(scene, {0.01, 0, 1 + sign * 0.45}), 0);
    EXPECT_GT(Clearance_m(scene, {0.01, sign * (0.3 - 2 * kOutline_m), 1}), 0);
  }
  EXPECT_GT(Clearance_m(scene, {0, 0, 1}), 0.3 - kOutline_m);
  const bool has_plate_with_hole =
      std::any_of(scene.objects.begin(), scene.objects.end(), [](const DetectedObject& object) {
        const auto* plate = object.model->shapes.empty()
                                ? nullptr
                                : std::get_if<Plate>(&object.model->shapes[0].shape);
        return plate != nullptr && plate->holes.size() == 1;
      });
  EXPECT_TRUE(has_plate_with_hole);
}

// A table of 1.2 x 1 m at z = 0 with a can on it, whose lower half a board in front of it may hide.
enum class Board { kNone, kHidesTheFoot };
SimulatedScene CanOnTable(Board board) {
  SimulatedScene scene;
  scene.objects.push_back({.name = "table",
                           .parts = {{MakeTranslation(0, 0, -0.015), Box{{1.2, 1.0, 0.03}}}},
                           .X_WO = Pose::Identity(),
                           .is_support = true});
  scene.objects.push_back({.name = "can",
                           .parts = {{Pose::Identity(), Cylinder{0.033, 0.16}}},
                           .X_WO = MakeTranslation(0.05, 0, 0.08)});
  if (board == Board::kHidesTheFoot) {
    scene.objects.push_back({.name = "board",
                             .parts = {{Pose::Identity(), Box{{0.03, 0.3, 0.12}}}},
                             .X_WO = MakeTranslation(-0.045, 0, 0.06)});
  }
  return scene;
}

const ShapePart* CanIn(const SceneInterpretation& scene, Pose* X_WS) {
  for (const DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) {
      *X_WS = object.X_WO * part.X_OS;
      if (KindOf(part.shape) == ShapeKind::kCylinder) return &part;
    }
  }
  return nullptr;
}

TEST(InterpretScene, CompletesACanBehindABoardDownToTheTableAndSaysSo) {
  const PinholeCamera camera = LookingAlong({1, 0, -1}, {-0.636, 0, 0.636});
  // A can that is seen as a whole is not completed.
  Pose X_WS;
  const SceneInterpretation open = Interpreted(CanOnTable(Board::kNone), camera);
  const ShapePart* seen = CanIn(open, &X_WS);
  ASSERT_NE(seen, nullptr);
  EXPECT_EQ(seen->role, PartRole::kFitted);
  const SceneInterpretation hidden = Interpreted(CanOnTable(Board::kHidesTheFoot), camera);
  const ShapePart* completed = CanIn(hidden, &X_WS);
  ASSERT_NE(completed, nullptr);
  EXPECT_EQ(completed->role, PartRole::kCompleted);
  // 3 sigma of the support and of the top.
  EXPECT_NEAR(TightBounds(completed->shape, X_WS).min().z(), 0, 0.005);
  EXPECT_NEAR(TightBounds(completed->shape, X_WS).max().z(), 0.16, 0.005);
  ASSERT_TRUE(completed->fit.has_value());
  EXPECT_LT(completed->fit->observed_fraction, seen->fit->observed_fraction);
}

// A box on a table of 1.2 x 1 m at z = 0, and the objects beside it.
SimulatedScene BoxOnTable(const Vector3& size_m, std::vector<SimulatedObject> beside) {
  SimulatedScene scene;
  scene.objects.push_back({.name = "table",
                           .parts = {{MakeTranslation(0, 0, -0.015), Box{{1.2, 1.0, 0.03}}}},
                           .X_WO = Pose::Identity(),
                           .is_support = true});
  scene.objects.push_back({.name = "box",
                           .parts = {{Pose::Identity(), Box{size_m}}},
                           .X_WO = MakeTranslation(0.1, 0, 0.5 * size_m.z())});
  for (SimulatedObject& object : beside) scene.objects.push_back(std::move(object));
  return scene;
}

// The box nearest to a place; null if there is none.
const ShapePart* BoxAt(const SceneInterpretation& scene, const Vector3& p_W, Pose* X_WS) {
  const ShapePart* nearest = nullptr;
  double nearest_m = 0.1;
  for (const DetectedObject& object : scene.objects) {
    if (object.kind != DetectedKind::kObject) continue;
    for (const ShapePart& part : object.model->shapes) {
      const Pose X_WPart = object.X_WO * part.X_OS;
      const double distance_m = (X_WPart.translation() - p_W).norm();
      if (KindOf(part.shape) != ShapeKind::kBox || distance_m >= nearest_m) continue;
      nearest_m = distance_m, nearest = &part, *X_WS = X_WPart;
    }
  }
  return nearest;
}

TEST(InterpretScene, CompletesABoxOfWhichTheTopAloneIsSeen) {
  const Vector3 size_m(0.15, 0.1, 0.12);
  const SceneInterpretation scene =
      Interpreted(BoxOnTable(size_m, {}), LookingAlong({0, 0, -1}, {0.1, 0, 0.9}));
  Pose X_WS;
  const ShapePart* box = BoxAt(scene, {0.1, 0, 0.1}, &X_WS);
  ASSERT_NE(box, nullptr);
  EXPECT_EQ(box->role, PartRole::kCompleted);
  // 3 sigma of the table and of the top, at 0.9 m.
  constexpr double kEither_m = 0.005;
  const Aabb bounds = TightBounds(box->shape, X_WS);
  EXPECT_NEAR(bounds.min().z(), 0, kEither_m);
  EXPECT_NEAR(bounds.max().z(), size_m.z(), kEither_m);
  EXPECT_GT(Clearance_m(scene, {0.1, 0.5 * size_m.y() + 0.02, 0.06}), 0.005);
}

TEST(InterpretScene, ABoxReachesToTheEndThatIsSeenBeyondAPost) {
  // The post stands in front of a third of the box and is higher: the box's face and top are seen
  // in two parts.
  const Vector3 size_m(0.1, 0.36, 0.1);
  const SimulatedObject post{.name = "post",
                             .parts = {{Pose::Identity(), Box{{0.03, 0.08, 0.3}}}},
                             .X_WO = MakeTranslation(-0.1, -0.06, 0.15)};
  const SceneInterpretation scene =
      Interpreted(BoxOnTable(size_m, {post}), LookingAlong({1, 0, -1}, {-0.636, 0, 0.7}));
  Pose X_WS;
  const ShapePart* box = BoxAt(scene, {0.1, 0, 0.05}, &X_WS);
  ASSERT_NE(box, nullptr);
  constexpr double kEdges_m = 0.006;  // two pixels at 1 m for either end
  const Aabb bounds = TightBounds(box->shape, X_WS);
  EXPECT_NEAR(bounds.min().y(), -0.5 * size_m.y(), kEdges_m);
  EXPECT_NEAR(bounds.max().y(), 0.5 * size_m.y(), kEdges_m);
}

TEST(InterpretScene, MakesOneObjectOfManyShapesOfWhatStandsOnASupportWithoutClusters) {
  const SceneInterpretation apart = Interpreted(KitchenCounter(), KitchenCamera());
  const SceneInterpretation whole =
      Interpreted(KitchenCounter(), KitchenCamera(), Clustering::kNone);
  const auto on_supports = [](const SceneInterpretation& scene) {
    return std::count_if(scene.objects.begin(), scene.objects.end(),
                         [](const auto& object) { return object.kind == DetectedKind::kObject; });
  };
  EXPECT_GE(on_supports(apart), 6);
  ASSERT_EQ(on_supports(whole), 1);
  std::set<ShapeKind> kinds;
  for (const ShapePart& part : whole.objects[0].model->shapes) kinds.insert(KindOf(part.shape));
  EXPECT_TRUE(kinds.contains(ShapeKind::kBox));
  EXPECT_TRUE(kinds.contains(ShapeKind::kCylinder));
  EXPECT_TRUE(kinds.contains(ShapeKind::kSphere));
}

TEST(InterpretScene, LosesNoPointOfASupportBesideItsPlate) {
  const PinholeCamera camera = KitchenCamera();
  const PointCloud cloud = Scan(KitchenCounter(), camera, {}).cloud;
  InterpretOptions options;
  options.X_WC = camera.X_WC;
  const auto scene = InterpretScene(cloud, options);
  ASSERT_TRUE(scene.ok()) << scene.status();
  for (std::size_t s = 0; s < scene->supports.size(); ++s) {
    const DetectedSupport& support = scene->supports[s];
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (scene->labels[i] != s + 1) continue;
      const Vector3 p_C = cloud.points[i].cast<double>();
      const Vector3 p_O = support.X_WO.inverse() * (camera.X_WC * p_C);
      // Slightly more than the tolerance that explains a point: poses are applied in doubles here,
      // in floats there.
      const double within_m = 1e-4 + ExplainedWithin_m(SensorNoise{}.AxialSigma_m(p_C.z()));
      double nearest_m = std::abs(SignedDistance_m(support.model->shapes[0].shape, p_O));
      for (const SurfacePart& part : support.model->surfaces) {
        if (nearest_m <= within_m) break;
        nearest_m = std::min(nearest_m, SignedDistance_m(part.surface, p_O));
      }
      ASSERT_LE(nearest_m, within_m) << "support " << s << ", point " << i;
    }
  }
}

}  // namespace
}  // namespace cwm::perception
