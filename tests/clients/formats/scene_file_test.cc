#include "clients/formats/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "clients/formats/file_bytes.h"
#include "tests/clients/formats/invalid_file.h"
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

std::string Repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
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
  ASSERT_EQ(object.shapes.size(), 4u);
  EXPECT_THAT(std::get<SceneBox>(object.shapes[0].shape).size_m, ElementsAre(0.1, 0.2, 0.3));
  EXPECT_THAT(object.shapes[0].pose.position_m, ElementsAre(1, 2, 3));
  EXPECT_EQ(std::get<SceneCylinder>(object.shapes[1].shape).height_m, 0.14);
  EXPECT_EQ(std::get<SceneCylinder>(object.shapes[1].shape).radius_m, 0.03);
  EXPECT_EQ(std::get<SceneCone>(object.shapes[2].shape).height_m, 0.2);
  EXPECT_EQ(std::get<SceneCone>(object.shapes[2].shape).radius_m, 0.05);
  EXPECT_THAT(object.shapes[2].pose.orientation_xyzw, ElementsAre(0, 0, 0, 1));
  EXPECT_EQ(std::get<SceneSphere>(object.shapes[3].shape).radius_m, 0.5);
}

TEST(SceneFile, ReadsMeshesAndPlanes) {
  const auto scene = ParseScene(Scene(R"(
    - id: statue
      meshes:
        - vertices: [[0, 0, 0], {x: 1, y: 0, z: 0}, [0, 1, 0], [0, 0, 1]]
          triangles: [[0, 2, 1], {vertex_indices: [0, 1, 3]}, [0, 3, 2], [1, 2, 3], [1, 1, 2]]
      mesh_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]
      planes: [{coef: [0, 0, 2, -4]}, {coef: [0, 0, -1, 0]}]
      plane_poses:
        - {position: [1, 0, 0], orientation: [0, 0, 0, 1]}
        - {position: [0, 0, 0], orientation: [0, 0, 0, 1]}
)"),
                                "s.yaml");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), 1u);
  const auto& shapes = scene->objects[0].shapes;
  ASSERT_EQ(shapes.size(), 3u);
  const auto& mesh = std::get<MeshFile>(shapes[0].shape);
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles.size(), 4u);
  EXPECT_THAT(scene->warnings, ElementsAre(HasSubstr("statue: 1 triangles that use a vertex")));
  // 2 z - 4 = 0 is the plane z = 2 with solid below; -z = 0 has solid above.
  ASSERT_TRUE(std::holds_alternative<SceneHalfSpace>(shapes[1].shape));
  EXPECT_THAT(shapes[1].pose.position_m, ElementsAre(1, 0, 2));
  EXPECT_THAT(shapes[1].pose.orientation_xyzw, ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(shapes[2].pose.orientation_xyzw, ElementsAre(1, 0, 0, 0));
}

TEST(SceneFile, ReadsTheRobotAndWhatItHoldsAndMayTouch) {
  const auto scene = ParseScene(R"(
robot_model_name: arm
robot_state:
  joint_state: {name: [a, b], position: [0.5, -1e-3]}
  multi_dof_joint_state:
    joint_names: [virtual_joint]
    transforms: [{translation: {x: 1, y: 0, z: 0}, rotation: [0, 0, 1, 0]}]
  attached_collision_objects:
    - link_name: hand
      object: {header: {frame_id: hand}, id: can,
               primitives: [{type: 3, dimensions: [0.2, 0.1, 0]}],
               primitive_poses: [{position: [0, 0, 0.1], orientation: [0, 0, 0, 1]}]}
      touch_links: [finger]
allowed_collision_matrix:
  entry_names: [hand, can]
  entry_values: [[false, true], {enabled: [1, 0]}]
  default_entry_names: [can]
  default_entry_values: [yes]
link_padding: [{link_name: hand, padding: 0.01}, {link_name: arm, padding: 0}]
link_scale: [{link_name: hand, scale: 1.0}]
world: {octomap: {octomap: {data: [1, 2]}}}
)",
                                "s.yaml");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->robot_model_name, "arm");
  ASSERT_EQ(scene->robot_state.joints.size(), 2u);
  EXPECT_EQ(scene->robot_state.joints[1].position, -1e-3);
  ASSERT_EQ(scene->robot_state.multi_dof_joints.size(), 1u);
  EXPECT_THAT(scene->robot_state.multi_dof_joints[0].transform.position_m, ElementsAre(1, 0, 0));
  ASSERT_EQ(scene->robot_state.attached.size(), 1u);
  const SceneAttachedObject& attached = scene->robot_state.attached[0];
  EXPECT_TRUE(attached.pose_is_in_link);
  EXPECT_EQ(attached.link, "hand");
  EXPECT_THAT(attached.touch_links, ElementsAre("finger"));
  EXPECT_EQ(std::get<SceneCylinder>(attached.object.shapes.at(0).shape).radius_m, 0.1);
  EXPECT_TRUE(scene->allowed_collisions.allowed[0][1]);
  EXPECT_FALSE(scene->allowed_collisions.allowed[1][1]);
  EXPECT_THAT(scene->allowed_collisions.defaults, ElementsAre(std::pair("can", true)));
  EXPECT_THAT(scene->warnings,
              ElementsAre(HasSubstr("link_padding of hand"), HasSubstr("world.octomap")));
}

TEST(SceneFile, ReadsWhatADifferenceTakesAway) {
  const auto scene = ParseScene(R"(
is_diff: true
world:
  collision_objects:
    - {id: a, operation: remove}
    - {id: b, operation: 1, primitives: []}
    - {id: c, operation: add, primitives: [{type: sphere, dimensions: [0.1]}],
       primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]}
)",
                                "s.yaml");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_TRUE(scene->is_diff);
  EXPECT_THAT(scene->removed, ElementsAre("a", "b"));
  ASSERT_EQ(scene->objects.size(), 1u);
  EXPECT_EQ(scene->objects[0].id, "c");
}

TEST(SceneFile, SaysOnceWhereTheMatrixContradictsItself) {
  std::string rows;
  for (int i = 0; i < 4; ++i) {
    rows += std::string(i == 0 ? "" : ", ") + "[" + Repeated("0, ", i) + Repeated("1, ", 4 - i) +
            "]";  // allowed only above the diagonal
  }
  const auto scene = ParseScene(
      "allowed_collision_matrix: {entry_names: [a, b, c, d], entry_values: [" + rows + "]}", "s");
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(scene->warnings,
              ElementsAre(AllOf(HasSubstr("two things of a and b, a and c, a and d, b and c, "),
                                HasSubstr("b and d and 1 more; "))));
}

TEST(SceneFile, PutsPosesIntoTheWorldByTheirFrames) {
  const std::string text = R"(
fixed_frame_transforms:
  - {child_frame_id: /shelf, transform: {translation: [0, 0, 1], rotation: [0, 0, 1, 0]}}
world:
  collision_objects:
    - {header: {frame_id: FRAME}, id: thing, primitives: [{type: sphere, dimensions: [1]}],
       primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}],
       pose: {position: [1, 0, 0], orientation: [0, 0, 0, 1]}}
)";
  const auto parse = [&](const std::string& frame, const std::string& world_frame) {
    std::string with_frame = text;
    with_frame.replace(with_frame.find("FRAME"), 5, frame);
    return ParseScene(with_frame, "s.yaml", {.world_frame = world_frame});
  };
  const auto on_shelf = parse("shelf", "");
  ASSERT_TRUE(on_shelf.ok()) << on_shelf.status();
  EXPECT_THAT(on_shelf->objects[0].pose.position_m, ElementsAre(-1, 0, 1));
  EXPECT_EQ(parse("/world", "")->objects[0].pose.position_m[0], 1);
  EXPECT_EQ(parse("odom", "odom")->objects[0].pose.position_m[0], 1);
  EXPECT_THAT(std::string(parse("odom", "").status().message()),
              AllOf(HasSubstr("collision_objects[0].header.frame_id is odom"),
                    HasSubstr("must be the world's frame")));
}

class HostileScene : public ::testing::TestWithParam<InvalidFile> {};

TEST_P(HostileScene, IsRefusedNamingFileFieldAndRule) {
  ExpectRefusal(ParseScene(GetParam().text, "hostile.yaml").status(), "hostile.yaml", GetParam());
}

INSTANTIATE_TEST_SUITE_P(
    InvalidFiles, HostileScene,
    ::testing::Values(
        InvalidFile{"NotYaml", "world: [", "YAML", "yaml-cpp: error"},
        InvalidFile{"DeeplyNested", std::string(100000, '['), "YAML", ""},
        InvalidFile{"Scalar", "just a word", "world.collision_objects", "is missing"},
        InvalidFile{"Empty", "", "world.collision_objects", "is missing"},
        InvalidFile{"NotAList", "world: {collision_objects: 3}", "collision_objects is 3",
                    "must be a list"},
        InvalidFile{"NoId", Scene("    - {primitives: []}\n"), "collision_objects[0].id",
                    "must be a name"},
        InvalidFile{"IdTwice", Scene(Object(kSphere, kIdentity) + Object(kSphere, kIdentity)),
                    "collision_objects[1].id is thing", "must not appear twice"},
        InvalidFile{"UnknownType", Scene(Object("{type: torus, dimensions: [1]}", kIdentity)),
                    "primitives[0].type is torus", "must be box, sphere, cylinder or cone"},
        InvalidFile{"TooFewDimensions", Scene(Object("{type: box, dimensions: [1, 2]}", kIdentity)),
                    "primitives[0].dimensions", "must be a list of 3 numbers"},
        InvalidFile{"NegativeDimension",
                    Scene(Object("{type: box, dimensions: [1, -2, 3]}", kIdentity)),
                    "primitives[0].dimensions[1] is -2", "must be positive"},
        InvalidFile{"NanDimension", Scene(Object("{type: sphere, dimensions: [nan]}", kIdentity)),
                    "dimensions[0] is nan", "must be a finite number"},
        InvalidFile{"HugeNumber", Scene(Object("{type: sphere, dimensions: [1e7]}", kIdentity)),
                    "dimensions[0] is 1e7", "must be at most 1e+06"},
        InvalidFile{"MeshOfAnotherFile",
                    Scene("    - {id: m, meshes: [{resource: a.stl}], mesh_poses: [" +
                          std::string(kIdentity) + "]}"),
                    "meshes[0].resource is a.stl", "only meshes with vertices"},
        InvalidFile{
            "CornerOutOfRange",
            Scene("    - {id: m, meshes: [{vertices: [[0, 0, 0]], triangles: [[0, 0, 1]]}], "
                  "mesh_poses: [" +
                  std::string(kIdentity) + "]}"),
            "triangles[0][2] is 1", "an index of 1 vertices"},
        InvalidFile{"PlaneWithoutNormal",
                    Scene("    - {id: p, planes: [{coef: [0, 0, 0, 1]}], plane_poses: [" +
                          std::string(kIdentity) + "]}"),
                    "planes[0].coef", "normal that is not 0"},
        InvalidFile{"RepeatedByAliases",
                    Scene("    - {id: m, meshes: [&m {vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
                          "triangles: [[0, 1, 2]]}" +
                          Repeated(", *m", 500) + "], mesh_poses: [&p " + std::string(kIdentity) +
                          Repeated(", *p", 500) + "]}"),
                    "mesh", "must not be repeated by aliases"},
        InvalidFile{
            "TouchLinksRepeatedByAliases",
            "robot_state: {attached_collision_objects: [&o {link_name: hand, touch_links: &l [" +
                Repeated("finger, ", 500) + "thumb], object: {id: o}}" + Repeated(", *o", 500) +
                "]}",
            "touch_links[", "must not be repeated by aliases"},
        InvalidFile{"TrianglesRepeatedByAliases",
                    Scene("    - {id: m, meshes: [{vertices: &v [[0, 0, 0], [1, 0, 0], [0, 1, 0]], "
                          "triangles: &t [[0, 1, 2]" +
                          Repeated(", [0, 1, 2]", 500) + "]}" +
                          Repeated(", {vertices: *v, triangles: *t}", 500) + "], mesh_poses: [&p " +
                          kIdentity + Repeated(", *p", 500) + "]}"),
                    "triangles[", "must not be repeated by aliases"},
        InvalidFile{"RowsRepeatedByAliases",
                    "allowed_collision_matrix: {entry_names: [a" + Repeated(", a", 999) +
                        "], entry_values: [&r [1" + Repeated(", 1", 999) + "]" +
                        Repeated(", *r", 999) + "]}",
                    "entry_values[", "must not be repeated by aliases"},
        InvalidFile{
            "AttachedButNowhere",
            Scene("    - {id: bare}\nrobot_state: {attached_collision_objects: [{link_name: hand, "
                  "object: {id: bare}}]}\n"),
            "attached_collision_objects[0].object.id is bare", "must have shapes"},
        InvalidFile{
            "AttachedTwice",
            Scene(Object(kSphere, kIdentity) +
                  "robot_state: {attached_collision_objects: [&a {link_name: hand, object: {id: "
                  "thing}}, *a]}\n"),
            "attached_collision_objects[1].object.id is thing", "must not be attached twice"},
        InvalidFile{"Removal", Scene("    - {id: p, operation: 1}"), "operation is 1",
                    "must be add"},
        InvalidFile{"Difference", "is_diff: perhaps\n" + Scene("    - {id: p}"),
                    "is_diff is perhaps", "must be true or false"},
        InvalidFile{"Append", "is_diff: true\n" + Scene("    - {id: p, operation: 2}"),
                    "operation is 2", "must be add or remove"},
        InvalidFile{
            "RemovalTwice",
            "is_diff: true\n" + Scene("    - {id: p, operation: 1}\n    - {id: p, operation: 1}"),
            "id is p", "must not appear twice"},
        InvalidFile{"FewerPositionsThanNames",
                    "robot_state: {joint_state: {name: [a, b], position: [1]}}",
                    "joint_state.position", "one for each of 2 names"},
        InvalidFile{
            "MatrixNotSquare",
            "allowed_collision_matrix: {entry_names: [a, b], entry_values: [[true, true], [true]]}",
            "entry_values[1]", "one for each of 2 entry_names"},
        InvalidFile{"NoTruthValue",
                    "allowed_collision_matrix: {entry_names: [a], entry_values: [[maybe]]}",
                    "entry_values[0][0] is maybe", "must be true or false"},
        InvalidFile{"MissingPose", Scene(Object(kSphere, "")), "primitive_poses",
                    "a pose for each of 1"},
        InvalidFile{"ZeroQuaternion",
                    Scene(Object(kSphere, "{position: [0, 0, 0], orientation: [0, 0, 0, 0]}")),
                    "primitive_poses[0].orientation", "within 1 % of 1"},
        InvalidFile{"PositionNotANumber",
                    Scene(Object(kSphere, "{position: [0, a, 0], orientation: [0, 0, 0, 1]}")),
                    "primitive_poses[0].position[1] is a", "must be a finite number"}),
    [](const ::testing::TestParamInfo<InvalidFile>& info) { return std::string(info.param.name); });

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
    for (const SceneObject& object : scene->objects) primitives += object.shapes.size();
    ++scenes;
  }
  EXPECT_EQ(scenes, 700);
  EXPECT_GT(primitives, 700u);
}

}  // namespace
}  // namespace cwm::formats
