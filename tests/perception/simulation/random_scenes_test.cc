#include "perception/simulation/random_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"
#include "perception/simulation/hidden_shares.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct Surface {
  std::vector<Vector3> points_W;
  Aabb bounds_W;
};

// Points all over a part's surface, at most `spacing_m` apart: each triangle of its mesh is sampled
// as a grid.
Surface Sample(const SimulatedObject& object, const Placed<>& part, double spacing_m) {
  const Pose X_WS = object.X_WO * part.X_FS;
  const TriangleMesh mesh = Tessellate(part.shape, 0.0005);
  Surface surface;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vector3& a = mesh.vertices[i];
    const Vector3 ab = mesh.vertices[j] - a;
    const Vector3 ac = mesh.vertices[k] - a;
    const double longest_m = std::max({ab.norm(), ac.norm(), (ab - ac).norm()});
    const int steps = static_cast<int>(std::ceil(longest_m / spacing_m));
    for (int u = 0; u <= steps; ++u) {
      for (int v = 0; u + v <= steps; ++v) {
        surface.points_W.push_back(X_WS * (a + (u * ab + v * ac) / steps));
        surface.bounds_W.extend(surface.points_W.back());
      }
    }
  }
  return surface;
}

// The depth of the surface's deepest point inside the object. The check is independent of the
// generator's rule: it samples surfaces and asks how deep they lie in the other solid.
double DeepestIn_m(const Surface& surface, const SimulatedObject& object) {
  double deepest_m = 0;
  for (const Placed<>& part : object.parts) {
    const Pose X_SW = (object.X_WO * part.X_FS).inverse();
    const Aabb bounds_W = TightBounds(part.shape, object.X_WO * part.X_FS);
    if (!bounds_W.intersects(surface.bounds_W)) continue;
    for (const Vector3& p_W : surface.points_W) {
      if (!bounds_W.contains(p_W)) continue;
      deepest_m = std::max(deepest_m, -SignedDistance_m(part.shape, X_SW * p_W));
    }
  }
  return deepest_m;
}

bool IsObject(const SimulatedObject& object) {
  return object.name.find('_') != std::string::npos && object.name.rfind("front", 0) != 0 &&
         object.name != "side_table";
}

struct FamilyOfScenes {
  SceneFamily family = SceneFamily::kTable;
  std::string name;
  int min_objects = 0;
  int max_objects = 0;
  int min_on_others = 0;  // objects that rest on others, over the examined scenes
};

class RandomScenes : public ::testing::TestWithParam<FamilyOfScenes> {
 protected:
  static constexpr int kScenes = 6;

  SimulatedView View(int seed) const {
    return RandomScene(GetParam().family, static_cast<std::uint64_t>(seed));
  }
};

TEST_P(RandomScenes, HoldNothingThatInterpenetrates) {
  constexpr double kSpacing_m = 0.004;  // corners and edges are always among the samples
  constexpr double kRounding_m = 1e-9;
  for (int seed = 1; seed <= kScenes; ++seed) {
    const SimulatedScene scene = View(seed).scene;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      if (!IsObject(scene.objects[i])) continue;
      for (const Placed<>& part : scene.objects[i].parts) {
        const Surface surface = Sample(scene.objects[i], part, kSpacing_m);
        for (std::size_t j = 0; j < scene.objects.size(); ++j) {
          if (j == i) continue;
          ASSERT_LE(DeepestIn_m(surface, scene.objects[j]), kRounding_m)
              << "seed " << seed << ": " << scene.objects[i].name << " in "
              << scene.objects[j].name;
        }
      }
    }
  }
}

class SeparateObjects : public RandomScenes {};
TEST_P(SeparateObjects, TouchTheTopOfASupport) {
  constexpr double kRounding_m = 1e-9;
  for (int seed = 1; seed <= kScenes; ++seed) {
    const SimulatedScene scene = View(seed).scene;
    for (const SimulatedObject& object : scene.objects) {
      if (!IsObject(object)) continue;
      const Aabb bounds = BoundsInWorld(object);
      const bool rests = std::any_of(
          scene.objects.begin(), scene.objects.end(), [&](const SimulatedObject& support) {
            if (!support.is_support) return false;
            const Aabb top = BoundsInWorld(support);
            return std::abs(bounds.min().z() - top.max().z()) <= kRounding_m &&
                   (bounds.min().head<2>().array() >= top.min().head<2>().array()).all() &&
                   (bounds.max().head<2>().array() <= top.max().head<2>().array()).all();
          });
      EXPECT_TRUE(rests) << "seed " << seed << ": " << object.name;
    }
  }
}

TEST_P(RandomScenes, ShowEveryObjectToTheCamera) {
  for (int seed = 1; seed <= kScenes; ++seed) {
    const SimulatedView view = View(seed);
    const SimulatedCloud scan = Scan(view.scene, view.camera, {.noiseless = true});
    std::map<int, int> points_of;
    for (const int object : scan.object) ++points_of[object];
    int objects = 0;
    for (std::size_t i = 0; i < view.scene.objects.size(); ++i) {
      if (!IsObject(view.scene.objects[i])) continue;
      ++objects;
      EXPECT_GT(points_of[static_cast<int>(i)], 50) << seed << view.scene.objects[i].name;
    }
    EXPECT_GE(objects, GetParam().min_objects) << seed;
    EXPECT_LE(objects, GetParam().max_objects) << seed;
  }
}

TEST_P(RandomScenes, NameEveryObjectOnceAndFurnitureFirst) {
  for (int seed = 1; seed <= kScenes; ++seed) {
    const SimulatedScene scene = View(seed).scene;
    std::set<std::string> names;
    bool objects_began = false;
    for (const SimulatedObject& object : scene.objects) {
      EXPECT_TRUE(names.insert(object.name).second) << object.name;
      objects_began = objects_began || IsObject(object);
      EXPECT_EQ(IsObject(object), objects_began) << object.name;
    }
  }
}

TEST_P(RandomScenes, AreTheSameForTheSameSeedAndOthersForAnother) {
  const auto same = [](const SimulatedView& a, const SimulatedView& b) {
    if (a.scene.objects.size() != b.scene.objects.size()) return false;
    if (a.camera.X_WC.matrix() != b.camera.X_WC.matrix()) return false;
    for (std::size_t i = 0; i < a.scene.objects.size(); ++i) {
      const SimulatedObject& x = a.scene.objects[i];
      const SimulatedObject& y = b.scene.objects[i];
      if (x.name != y.name || x.X_WO.matrix() != y.X_WO.matrix()) return false;
      for (std::size_t part = 0; part < x.parts.size(); ++part) {
        if (!(x.parts[part].shape == y.parts[part].shape)) return false;
      }
    }
    return true;
  };
  EXPECT_TRUE(same(View(1), View(1)));
  EXPECT_FALSE(same(View(1), View(2)));
}

class TouchingObjects : public RandomScenes {};
TEST_P(TouchingObjects, RestOnASupportOrOnOneAnother) {
  constexpr double kRounding_m = 1e-9;
  int on_others = 0;
  for (int seed = 1; seed <= kScenes; ++seed) {
    const SimulatedScene scene = View(seed).scene;
    for (const SimulatedObject& object : scene.objects) {
      if (!IsObject(object) || object.name.rfind("nested", 0) == 0) continue;
      const Aabb bounds = BoundsInWorld(object);
      const auto carries_on = [&](const Aabb& other) {
        return std::abs(bounds.min().z() - other.max().z()) <= kRounding_m &&
               (bounds.center().head<2>().array() >= other.min().head<2>().array()).all() &&
               (bounds.center().head<2>().array() <= other.max().head<2>().array()).all();
      };
      const auto carries = [&](const SimulatedObject& below) {
        return carries_on(BoundsInWorld(below)) ||
               std::ranges::any_of(below.parts, [&](const Placed<>& part) {
                 return carries_on(TightBounds(part.shape, below.X_WO * part.X_FS));
               });
      };
      const auto below = std::ranges::find_if(scene.objects, carries);
      ASSERT_NE(below, scene.objects.end()) << "seed " << seed << ": " << object.name;
      on_others += !below->is_support;
    }
  }
  const bool stands_apart = GetParam().min_on_others == 0;
  EXPECT_EQ(on_others == 0, stands_apart);
  EXPECT_GE(on_others, GetParam().min_on_others);
}

const auto kSeparateFamilies =
    ::testing::Values(FamilyOfScenes{SceneFamily::kTable, "table", 4, 9},
                      FamilyOfScenes{SceneFamily::kClutter, "clutter", 8, 16},
                      FamilyOfScenes{SceneFamily::kKitchen, "kitchen", 6, 15},
                      FamilyOfScenes{SceneFamily::kVessels, "vessels", 4, 8},
                      FamilyOfScenes{SceneFamily::kLids, "lids", 4, 8});
const auto kTouchingFamilies =
    ::testing::Values(FamilyOfScenes{SceneFamily::kStacks, "stacks", 4, 19, 12},
                      FamilyOfScenes{SceneFamily::kHeaps, "heaps", 4, 17, 6},
                      FamilyOfScenes{SceneFamily::kRows, "rows", 3, 15},
                      FamilyOfScenes{SceneFamily::kEdges, "edges", 3, 7},
                      FamilyOfScenes{SceneFamily::kContainers, "containers", 3, 12, 4});
const auto kNameOfFamily = [](const auto& info) { return info.param.name; };
INSTANTIATE_TEST_SUITE_P(Separate, RandomScenes, kSeparateFamilies, kNameOfFamily);
INSTANTIATE_TEST_SUITE_P(Touching, RandomScenes, kTouchingFamilies, kNameOfFamily);
INSTANTIATE_TEST_SUITE_P(Families, SeparateObjects, kSeparateFamilies, kNameOfFamily);
INSTANTIATE_TEST_SUITE_P(Families, TouchingObjects, kTouchingFamilies, kNameOfFamily);

constexpr double kDegree = std::numbers::pi / 180;

// Many scenes, drawn once for all tests that use them.
const std::vector<SimulatedView>& ManyTables() {
  constexpr std::uint64_t kOfEach = 30;
  static const std::vector<SimulatedView> views = [] {
    std::vector<SimulatedView> drawn;
    for (std::uint64_t seed = 1; seed <= kOfEach; ++seed) {
      drawn.push_back(RandomScene(SceneFamily::kTable, seed));
      drawn.push_back(RandomScene(SceneFamily::kClutter, seed));
    }
    return drawn;
  }();
  return views;
}

TEST(RandomTables, AreSeenFromCloseByAndFromAbove) {
  for (const SimulatedView& view : ManyTables()) {
    const Pose& X_WC = view.camera.X_WC;
    const double down_rad = -std::asin(X_WC.linear()(2, 2));
    EXPECT_GE(down_rad, 20 * kDegree);
    EXPECT_LE(down_rad, 70 * kDegree);
    // The optical axis meets the world's z axis 50 mm above the table.
    const double top_m = BoundsInWorld(view.scene.objects[0]).max().z();
    const double distance_m = (X_WC.translation() - Vector3(0, 0, top_m + 0.05)).norm();
    EXPECT_GE(distance_m, 0.6);
    EXPECT_LE(distance_m, 1.2);
  }
}

// True if no axis of the solid is upright.
bool IsTilted(const SimulatedObject& object) {
  const Matrix3 R_WS = (object.X_WO * object.parts[0].X_FS).linear();
  if (std::holds_alternative<Box>(object.parts[0].shape)) {
    return R_WS.row(2).cwiseAbs().maxCoeff() < 0.999;
  }
  return std::abs(R_WS(2, 2)) < 0.999;
}

TEST(RandomTables, LayOrLeanAboutAThirdOfTheObjects) {
  int tilted = 0;
  int objects = 0;
  std::map<std::size_t, int> of_kind;
  for (const SimulatedView& view : ManyTables()) {
    for (const SimulatedObject& object : view.scene.objects) {
      if (!IsObject(object)) continue;
      ++of_kind[object.parts[0].shape.index()];
      if (std::holds_alternative<Sphere>(object.parts[0].shape)) continue;
      ++objects;
      tilted += IsTilted(object);
    }
  }
  EXPECT_EQ(of_kind.size(), 4U);
  for (const auto& [kind, count] : of_kind) EXPECT_GT(count, objects / 10) << kind;
  EXPECT_GT(tilted, objects / 4);
  EXPECT_LT(tilted, objects * 9 / 20);
}

TEST(RandomTables, HideAFifthOfObjectsThatStandApartAtMost) {
  // The generator counts every fourth pixel of rows and columns.
  constexpr double kCoarseness = 0.05;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulatedView view = RandomScene(SceneFamily::kTable, seed);
    const std::vector<double> hidden = HiddenShares(view.scene, view.camera);
    for (std::size_t i = 0; i < hidden.size(); ++i) {
      if (!IsObject(view.scene.objects[i])) continue;
      EXPECT_LE(hidden[i], 0.2 + kCoarseness) << seed << view.scene.objects[i].name;
    }
  }
}

TEST(RandomClutter, HidesManyObjectsInPart) {
  constexpr double kCoarseness = 0.05;
  int objects = 0;
  int in_part = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SimulatedView view = RandomScene(SceneFamily::kClutter, seed);
    const std::vector<double> hidden = HiddenShares(view.scene, view.camera);
    for (std::size_t i = 0; i < hidden.size(); ++i) {
      if (!IsObject(view.scene.objects[i])) continue;
      ++objects;
      in_part += hidden[i] >= 0.2;
      EXPECT_LE(hidden[i], 0.7 + kCoarseness) << seed << view.scene.objects[i].name;
    }
  }
  EXPECT_GT(in_part, 2 * objects / 5);
}

TEST(HiddenShares, CountWhatOthersCover) {
  const auto board = [](const char* name, double size_m, double depth_m) {
    return SimulatedObject{.name = name,
                           .parts = {{.shape = Box{.size_m = {size_m, size_m, 0.001}}}},
                           .X_WO = MakeTranslation(0, 0, depth_m)};
  };
  SimulatedScene scene{.objects = {board("far", 0.4, 2), board("near", 0.1, 1)}};
  // The near board covers (0.1 / 1)^2 / (0.4 / 2)^2 of the far one, apart from a border of pixels
  // and the boards' thickness.
  EXPECT_NEAR(HiddenShares(scene, PinholeCamera())[0], 0.25, 0.02);
  EXPECT_EQ(HiddenShares(scene, PinholeCamera())[1], 0);
  scene.objects[0].X_WO.translation().z() = -1;
  EXPECT_EQ(HiddenShares(scene, PinholeCamera())[0], 1);
}

}  // namespace
}  // namespace cwm::perception
