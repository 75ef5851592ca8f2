// The ".scene" format, and both formats cut and changed at random.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "clients/formats/scene_file.h"

namespace cwm::formats {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Every shape, with object poses, subframes and an id with a space.
constexpr char kNewer[] = R"((noname)+
* Big box
1 2 3
0 0 0 1
2
box
0.1 0.2 0.3
0 0 1
0 0 0.6 0.8
0 0 0 0
sphere
0.5
0 0 0
0 0 0 1
1 0 0 1
1
handle
0 0 1
0 0 0 1
* rest
0 0 0
0 0 0 1
4
cylinder
0.03 0.14
0 0 0
0 0 0 1
0 0 0 0
cone
0.05 0.2
0 0 0
0 0 0 1
0 0 0 0
plane
0 0 1 -2
0 0 0
0 0 0 1
0 0 0 0
mesh
4 4
0 0 0
1 0 0
0 1 0
0 0 1e-3
0 2 1
0 1 3
0 3 2
1 2 3
0 0 0
0 0 0 1
0 0 0 0
0
.
)";

// The format before objects had poses.
constexpr char kOlder[] =
    "(noname)+\n* crate\n1\nbox\n0.1 0.2 0.3\n1 2 3\n0 0 0 1\n0 0 0 0\n* ball\n1\nsphere\n0.5\n"
    "0 0 1\n0 0 0 1\n0 0 0 0\n.\n";

constexpr char kYaml[] = R"(
robot_state:
  joint_state: {name: [a], position: [0.5]}
  multi_dof_joint_state: {joint_names: [v], 
                          transforms: [{translation: [0, 0, 0], rotation: [0, 0, 0, 1]}]}
allowed_collision_matrix: {entry_names: [a], entry_values: [[true]]}
world:
  collision_objects:
    - id: all
      pose: {position: {x: 0, y: 0, z: 1}, orientation: {x: 0, y: 0, z: 0, w: 1}}
      primitives: [{type: box, dimensions: [0.1, 0.2, 0.3]}]
      primitive_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]
      meshes: [{vertices: [[0, 0, 0], [1, 0, 0], [0, 1, 0]], triangles: [[0, 1, 2]]}]
      mesh_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]
      planes: [{coef: [0, 0, 1, 0]}]
      plane_poses: [{position: [1, 2, 3], orientation: [0, 0, 0, 1]}]
)";

TEST(SceneText, ReadsEveryShapeWithPosesOfObjects) {
  const auto scene = ParseScene(kNewer, "s.scene");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), 2u);
  EXPECT_EQ(scene->objects[0].id, "Big box");
  EXPECT_THAT(scene->objects[0].pose.position_m, ElementsAre(1, 2, 3));
  EXPECT_THAT(scene->objects[0].shapes[0].pose.position_m, ElementsAre(0, 0, 1));
  EXPECT_THAT(scene->objects[0].shapes[0].pose.orientation_xyzw, ElementsAre(0, 0, 0.6, 0.8));
  const auto& shapes = scene->objects[1].shapes;
  ASSERT_EQ(shapes.size(), 4u);
  EXPECT_EQ(std::get<SceneCylinder>(shapes[0].shape).radius_m, 0.03);
  EXPECT_EQ(std::get<SceneCylinder>(shapes[0].shape).height_m, 0.14);
  EXPECT_EQ(std::get<SceneCone>(shapes[1].shape).radius_m, 0.05);
  EXPECT_TRUE(std::holds_alternative<SceneHalfSpace>(shapes[2].shape));
  EXPECT_THAT(shapes[2].pose.position_m, ElementsAre(0, 0, 2));
  EXPECT_EQ(std::get<MeshFile>(shapes[3].shape).triangles.size(), 4u);
  EXPECT_THAT(scene->warnings, ElementsAre());
}

TEST(SceneText, ReadsFilesFromBeforeObjectsHadPoses) {
  const auto scene = ParseScene(kOlder, "s.scene");
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_EQ(scene->objects.size(), 2u);
  EXPECT_TRUE(IsIdentity(scene->objects[0].pose));
  EXPECT_THAT(scene->objects[0].shapes[0].pose.position_m, ElementsAre(1, 2, 3));
  EXPECT_EQ(std::get<SceneSphere>(scene->objects[1].shapes[0].shape).radius_m, 0.5);
}

TEST(SceneText, SaysWhichLineIsWrong) {
  const auto message = [](std::string from, const std::string& to) {
    std::string text = kNewer;
    text.replace(text.find(from), from.size(), to);
    const auto scene = ParseScene(text, "bad.scene");
    EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << from << " to " << to;
    return std::string(scene.status().message());
  };
  EXPECT_THAT(message("0.1 0.2", "0.1 nan"),
              AllOf(HasSubstr("bad.scene: line 7: box is nan"), HasSubstr("finite number")));
  EXPECT_THAT(message("0.1 0.2", "0.1 -1"), HasSubstr("line 7: box is -1, must be positive"));
  EXPECT_THAT(message("0 0 0.6 0.8", "0 0 0.6 0.6"), HasSubstr("line 9: orientation has length"));
  EXPECT_THAT(message("* rest", "* Big box"), HasSubstr("id is Big box, must not appear twice"));
  EXPECT_THAT(message("cone", "torus"), HasSubstr("shape is torus, must be box, sphere"));
  EXPECT_THAT(message("4 4", "4 4000000000"), HasSubstr("the rest of the file can hold"));
  EXPECT_THAT(message("1 2 3\n0 0 0\n", "1 2 4\n0 0 0\n"), HasSubstr("an index of 4 vertices"));
  EXPECT_THAT(message("0 0 1 -2", "0 0 0 -2"), HasSubstr("normal that is not 0"));
  EXPECT_THAT(message(".\n", ""), HasSubstr("must be a line with \".\""));
}

// Any input gives a scene or an INVALID_ARGUMENT that begins with the file's name.
void ExpectSceneOrError(const std::string& bytes) {
  const auto scene = ParseScene(bytes, "fuzz");
  if (scene.ok()) return;
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kInvalidArgument) << scene.status();
  EXPECT_EQ(std::string(scene.status().message()).rfind("fuzz: ", 0), 0u) << scene.status();
}

TEST(SceneText, CutAtEveryByteIsRefusedOrRead) {
  for (const std::string text : {kNewer, kOlder, kYaml}) {
    ASSERT_TRUE(ParseScene(text, "whole").ok());
    for (std::size_t end = 0; end < text.size(); ++end) ExpectSceneOrError(text.substr(0, end));
  }
  for (const std::string text : {kNewer, kOlder}) {
    for (std::size_t end = 0; end + 2 < text.size(); ++end) {
      EXPECT_FALSE(ParseScene(text.substr(0, end), "cut").ok()) << "at byte " << end;
    }
  }
}

TEST(SceneText, ChangedAtRandomIsRefusedOrRead) {
  std::mt19937 random(7);
  std::string alphabet = "0123456789.-+e*[]{},:\n \tnaif&!|>%@\"'#\\\xff";
  alphabet.push_back('\0');
  for (const std::string text : {kNewer, kOlder, kYaml}) {
    for (int round = 0; round < 3000; ++round) {
      std::string changed = text;
      for (int change = 0; change < 1 + round % 4; ++change) {
        const std::size_t at = random() % changed.size();
        const char c = alphabet[random() % alphabet.size()];
        if (random() % 3 == 0) {
          changed.erase(at, 1 + random() % 8);
        } else if (random() % 2 == 0) {
          changed.insert(at, 1, c);
        } else {
          changed[at] = c;
        }
        if (changed.empty()) changed = "\n";
      }
      ExpectSceneOrError(changed);
    }
  }
}

}  // namespace
}  // namespace cwm::formats
