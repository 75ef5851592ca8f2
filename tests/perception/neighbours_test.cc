// Objects that stand beside each other, on one table and on two, are not mixed up.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "collision/geometry/aabb.h"
#include "tests/perception/model/tilted_vessels.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

// Expects as many objects as places, and each place near the middle of exactly one object.
void ExpectOneEach(const SceneInterpretation& scene, const std::vector<Vector2>& places) {
  EXPECT_EQ(scene.objects.size(), places.size());
  for (const Vector2& place : places) {
    const auto stands_there = [&](const DetectedObject& object) {
      return std::ranges::any_of(object.model->shapes, [&](const ShapePart& part) {
        return ((object.X_WO * part.X_OS).translation().head<2>() - place).norm() < 0.02;
      });
    };
    EXPECT_EQ(std::ranges::count_if(scene.objects, stands_there), 1) << place.transpose();
  }
}

SimulatedObject Upright(const VesselWall& wall, const Vector2& place) {
  SimulatedObject vessel = TiltedVessel(wall, 0, 0);
  vessel.X_WO.translation().head<2>() = place;
  return vessel;
}

struct Row {
  std::string name;
  std::vector<std::pair<VesselWall, Vector2>> vessels;
};

void PrintTo(const Row& row, std::ostream* out) { *out << row.name; }

class VesselsBeside : public ::testing::TestWithParam<Row> {};

// The floors of all vessels share a plane, and their walls hide the table between them.
TEST_P(VesselsBeside, AreOneObjectEach) {
  SimulatedScene kitchen{{Table()}};
  std::vector<Vector2> places;
  for (const auto& [wall, place] : GetParam().vessels) {
    kitchen.objects.push_back(Upright(wall, place));
    places.push_back(place);
  }
  ExpectOneEach(Interpreted(kitchen), places);
}

INSTANTIATE_TEST_SUITE_P(
    All, VesselsBeside,
    ::testing::Values(
        Row{"Bowls", {{BowlWall(), {0, -0.1}}, {BowlWall(), {0, 0.1}}}},
        Row{"BowlsInDepth", {{BowlWall(), {-0.1, 0}}, {BowlWall(), {0.1, 0.02}}}},
        Row{"PanAndBowl", {{PanWall(), {0.05, 0.15}}, {BowlWall(), {-0.1, -0.05}}}},
        Row{"MugsAndBowl",
            {{MugWall(), {-0.05, -0.15}}, {MugWall(), {-0.05, 0.15}}, {BowlWall(), {0, 0}}}}),
    [](const auto& named) { return named.param.name; });

class PacketsInARow : public ::testing::TestWithParam<std::vector<double>> {};

// Side by side, flush at the front, of different heights: the fronts are one face, the tops are
// not.
TEST_P(PacketsInARow, AreOneBoxEach) {
  constexpr double kWidth_m = 0.07, kDepth_m = 0.08;
  SimulatedScene shelf{{Table()}};
  std::vector<Vector3> middles;
  for (std::size_t k = 0; k < GetParam().size(); ++k) {
    const double height_m = GetParam()[k];
    middles.emplace_back(0, (static_cast<double>(k) - 1) * (kWidth_m + 0.002), 0.5 * height_m);
    shelf.objects.push_back(
        MakeObject("packet" + std::to_string(k), Box{{kDepth_m, kWidth_m, height_m}},
                   MakeTranslation(middles[k].x(), middles[k].y(), middles[k].z())));
  }
  const SceneInterpretation scene = Interpreted(shelf);
  EXPECT_EQ(scene.objects.size(), middles.size());
  for (const Vector3& middle : middles) {
    const auto is_it = [&](const DetectedObject& object) {
      if (object.model->shapes.size() != 1) return false;
      const ShapePart& part = object.model->shapes.front();
      const Aabb found = TightBounds(part.shape, object.X_WO * part.X_OS);
      const Vector3 size_m(kDepth_m, kWidth_m, 2 * middle.z());
      return std::holds_alternative<Box>(part.shape) && (found.center() - middle).norm() < 0.01 &&
             (found.sizes() - size_m).cwiseAbs().maxCoeff() < 0.015;
    };
    EXPECT_EQ(std::ranges::count_if(scene.objects, is_it), 1) << middle.transpose();
  }
}

INSTANTIATE_TEST_SUITE_P(Heights_m, PacketsInARow,
                         ::testing::Values(std::vector{0.16, 0.12}, std::vector{0.1, 0.14, 0.18},
                                           std::vector{0.16, 0.1, 0.18},
                                           std::vector{0.12, 0.16, 0.1},
                                           std::vector{0.16, 0.1, 0.18, 0.12}));

// The box is linked to the face of the table's edge, which is no object on the table.
TEST(EdgeOfTheTable, IsNoObjectWhereAnObjectJutsOverIt) {
  Pose X_WO = MakeTranslation(-0.58, 0, 0.03);
  X_WO.rotate(Eigen::AngleAxisd(0.26, Vector3::UnitZ()));
  const SimulatedScene kitchen{
      {Table(), MakeObject("box", Box{{0.15, 0.1, 0.06}}, X_WO),
       MakeObject("can", Cylinder{0.035, 0.1}, MakeTranslation(-0.56, 0.2, 0.05))}};
  PinholeCamera camera = TableCamera();
  camera.X_WC.translation() += Vector3(-0.35, 0, 0);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    InterpretOptions options;
    options.X_WC = camera.X_WC;
    const auto scene = InterpretScene(Scan(kitchen, camera, {.seed = seed}).cloud, options);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(std::ranges::count(scene->objects, DetectedKind::kObject, &DetectedObject::kind), 2)
        << "seed " << seed;
  }
}

// A low table behind the high one, whose edge hides where the objects on the low one stand.
TEST(LowTable, CarriesWhatItsHiddenPartIsUnder) {
  constexpr double kLower_m = -0.2;
  SimulatedObject low = Table();
  low.name = "low table";
  low.X_WO = MakeTranslation(1.25, 0, kLower_m);
  SimulatedObject floor = MakeObject("floor", HalfSpace{}, MakeTranslation(0, 0, -0.75));
  floor.is_support = true;
  const std::vector<Vector2> places{{0.9, 0.15}, {0.88, -0.15}, {-0.1, 0.2}};
  const SceneInterpretation scene =
      Interpreted({{Table(), std::move(low), std::move(floor),
                    MakeObject("box", Box{{0.15, 0.12, 0.2}},
                               MakeTranslation(places[0].x(), places[0].y(), kLower_m + 0.1)),
                    MakeObject("can", Cylinder{0.05, 0.2},
                               MakeTranslation(places[1].x(), places[1].y(), kLower_m + 0.1)),
                    MakeObject("near can", Cylinder{0.04, 0.12},
                               MakeTranslation(places[2].x(), places[2].y(), 0.06))}});
  ExpectOneEach(scene, places);
  EXPECT_EQ(scene.supports.size(), 3u);
  for (const DetectedObject& object : scene.objects) {
    for (const ShapePart& part : object.model->shapes) {
      const Aabb bounds = TightBounds(part.shape, object.X_WO * part.X_OS);
      EXPECT_LT(bounds.sizes().z(), 0.25) << "reaches down to the floor";
    }
  }
}

}  // namespace
}  // namespace cwm::perception
