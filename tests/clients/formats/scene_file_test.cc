#include "clients/formats/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "clients/formats/file_bytes.h"
#include "tests/support/outside_data.h"

namespace cwm::formats {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Scene(const std::string& objects) {
  return "name: test\nworld:\n  collision_objects:\n" + objects;
}

std::string Object(const std::string& primitive, const std::string& pose) {
  return "    - {id: thing, primitives: [" + primitive + "], primitive_poses: [" + pose + "]}\n";
}

const char kIdentity[] = "{position: [1, 2, 3], orientation: [0, 0, 0, 1]}";
const char kSphere[] = "{type: sphere, dimensions: [0.5]}";

TEST(SceneFile, ReadsEveryPrimitiveWithHeightBeforeRadius) {
  const auto scene = ParseScene(Scene(R"(
    - id: all
      pose: {position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      primitives:
        - {type: box, dimensions: [0.1, 0.2, 0.3]}
        - {type: cylinder, dimensions: [0.14, 0.03]}
        - {type: cone, dimensions: [0.2, 0.05]}
        - {type: sphere, dimensions: [0.5]}
      primitive_poses:
        - {position: [1, 2, 3], orientation: [0, 0, 0, 1]}
        - {position: [0, 0, 0], orientation: [0, 0, 0.6, 0.8]}
        - {position: [0, 0, 0], orientation: [0, 0, 0, 1.005]}
        - {position: [0, 0, 0], orientation: [0, 0, 0, -1]}
)"),
                                "s.yaml");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), 1u);
  const SceneObject& object = scene->objects[0];
  EXPECT_THAT(object.pose.position_m, ElementsAre(0, 0, 1));
  ASSERT_EQ(object.primitives.size(), 4u);
  EXPECT_THAT(std::get<SceneBox>(object.primitives[0].shape).size_m, ElementsAre(0.1, 0.2, 0.3));
  EXPECT_THAT(object.primitives[0].pose.position_m, ElementsAre(1, 2, 3));
  EXPECT_EQ(std::get<SceneCylinder>(object.primitives[1].shape).height_m, 0.14);
  EXPECT_EQ(std::get<SceneCylinder>(object.primitives[1].shape).radius_m, 0.03);
  EXPECT_EQ(std::get<SceneCone>(object.primitives[2].shape).height_m, 0.2);
  EXPECT_EQ(std::get<SceneCone>(object.primitives[2].shape).radius_m, 0.05);
  EXPECT_THAT(object.primitives[2].pose.orientation_xyzw, ElementsAre(0, 0, 0, 1));
  EXPECT_EQ(std::get<SceneSphere>(object.primitives[3].shape).radius_m, 0.5);
}

TEST(SceneFile, LeavesMeshesOutWithAWarning) {
  const auto scene =
      ParseScene(Scene("    - {id: statue, meshes: [{vertices: []}], mesh_poses: [{}]}\n" +
                       Object(kSphere, kIdentity)),
                 "s.yaml");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->objects.size(), 1u);
  EXPECT_THAT(scene->warnings, ElementsAre(HasSubstr("statue: 1 meshes left out"),
                                           HasSubstr("statue: left out, it has no primitives")));
}

struct Lie {
  const char* name;
  std::string text;
  const char* field;
  const char* rule;
};

class HostileScene : public ::testing::TestWithParam<Lie> {};

TEST_P(HostileScene, IsRefusedNamingFileFieldAndRule) {
  const auto scene = ParseScene(GetParam().text, "hostile.yaml");
  ASSERT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << scene.status();
  EXPECT_THAT(
      std::string(scene.status().message()),
      AllOf(HasSubstr("hostile.yaml: "), HasSubstr(GetParam().field), HasSubstr(GetParam().rule)));
}

INSTANTIATE_TEST_SUITE_P(
    Lies, HostileScene,
    ::testing::Values(
        Lie{"NotYaml", "world: [", "YAML", "yaml-cpp: error"},
        Lie{"DeeplyNested", std::string(100000, '['), "YAML", ""},
        Lie{"Scalar", "just a word", "world.collision_objects", "is missing"},
        Lie{"Empty", "", "world.collision_objects", "is missing"},
        Lie{"NotAList", "world: {collision_objects: 3}", "collision_objects is 3",
            "must be a list"},
        Lie{"NoId", Scene("    - {primitives: []}\n"), "collision_objects[0].id", "must be a name"},
        Lie{"IdTwice", Scene(Object(kSphere, kIdentity) + Object(kSphere, kIdentity)),
            "collision_objects[1].id is thing", "must not appear twice"},
        Lie{"UnknownType", Scene(Object("{type: torus, dimensions: [1]}", kIdentity)),
            "primitives[0].type is torus", "must be box, sphere, cylinder or cone"},
        Lie{"TooFewDimensions", Scene(Object("{type: box, dimensions: [1, 2]}", kIdentity)),
            "primitives[0].dimensions", "must be a list of 3 numbers"},
        Lie{"NegativeDimension", Scene(Object("{type: box, dimensions: [1, -2, 3]}", kIdentity)),
            "primitives[0].dimensions[1] is -2", "must be positive"},
        Lie{"NanDimension", Scene(Object("{type: sphere, dimensions: [nan]}", kIdentity)),
            "dimensions[0] is nan", "must be a finite number"},
        Lie{"MissingPose", Scene(Object(kSphere, "")), "primitive_poses", "a pose for each of 1"},
        Lie{"ZeroQuaternion",
            Scene(Object(kSphere, "{position: [0, 0, 0], orientation: [0, 0, 0, 0]}")),
            "primitive_poses[0].orientation", "within 1 % of 1"},
        Lie{"PositionNotANumber",
            Scene(Object(kSphere, "{position: [0, a, 0], orientation: [0, 0, 0, 1]}")),
            "primitive_poses[0].position[1] is a", "must be a finite number"}),
    [](const ::testing::TestParamInfo<Lie>& info) { return std::string(info.param.name); });

TEST(SceneFile, ReadsEveryMotionBenchMakerScene) {
  const auto folder = testing::OutsideData("motion_bench_maker");
  if (!folder) GTEST_SKIP() << "planning scenes (motion_bench_maker) are not in CWM_DATA";
  int scenes = 0;
  std::size_t primitives = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*folder)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("scene", 0) != 0 || entry.path().extension() != ".yaml") continue;
    const auto scene = ParseScene(*ReadFileBytes(entry.path().string()), name);
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_TRUE(scene->warnings.empty()) << name;
    EXPECT_FALSE(scene->objects.empty()) << name;
    for (const SceneObject& object : scene->objects) primitives += object.primitives.size();
    ++scenes;
  }
  EXPECT_EQ(scenes, 700);
  EXPECT_GT(primitives, 700u);
}

}  // namespace
}  // namespace cwm::formats
