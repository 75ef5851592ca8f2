// Import and export of planning scenes, as a user types them.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "tests/e2e/server_fixture.h"
#include "tests/support/outside_data.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ContainsRegex;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

std::string ContentOf(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

// The first line of both formats has the world's name.
std::string AfterTheName(const std::string& scene) { return scene.substr(scene.find('\n')); }

constexpr char kUrdf[] = R"(<robot name="arm">
<link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="hand">
<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint></robot>
)";

constexpr char kScene[] = R"(
robot_model_name: arm
robot_state:
  joint_state: {name: [shoulder, ghost], position: [1.5, 0.25]}
  multi_dof_joint_state: {joint_names: [virtual_joint], transforms: [{translation: [1, 2, 0], rotation: [0, 0, 0, 1]}]}
allowed_collision_matrix:
  entry_names: [base, hand, post, <octomap>]
  entry_values: [[false, true, true, true], [true, false, false, false], [true, false, false, false], [true, false, false, false]]
  default_entry_names: [floor]
  default_entry_values: [true]
link_padding: [{link_name: hand, padding: 0.01}]
world:
  collision_objects:
    - {id: post, primitives: [{type: box, dimensions: [0.2, 0.2, 0.2]}], primitive_poses: [{position: [1.5, 2, 0], orientation: [0, 0, 0, 1]}]}
    - {id: floor, planes: [{coef: [0, 0, 1, 1]}], plane_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]}
    - id: big mesh
      meshes: [{vertices: [[0, 0, 0], [0.3, 0, 0], [0, 0.3, 0], [0, 0, 0.3]], triangles: [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]}]
      mesh_poses: [{position: [5, 0, 0], orientation: [0, 0, 0, 1]}]
)";

class PlanningSceneCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    std::ofstream(scratch() / "arm.urdf") << kUrdf;
    std::ofstream(scratch() / "scene.yaml") << kScene;
  }
  void LoadArm(const std::string& world = "default") {
    CwmJson({"robot", "load", scratch() / "arm.urdf", "--world", world});
  }
  std::int64_t Revision() {
    return std::stoll(CwmJson({"objects"}).at("revision").get<std::string>());
  }
};

TEST_F(PlanningSceneCommand, ImportTakesObjectsStateAndPairsInOneRevision) {
  LoadArm();
  const ProcessResult run = Cwm({"import", scratch() / "scene.yaml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("the state of arm (1 joint value and its base)"),
                             HasSubstr("3 objects (1 mesh)"), HasSubstr("3 allowed pairs"),
                             HasSubstr("revision 2")));
  for (const char* warning :
       {"ghost: left out", "link_padding of hand", "put as big_mesh", "<octomap>: left out"}) {
    EXPECT_THAT(run.err, HasSubstr(warning));
  }
  const json robot = CwmJson({"robot", "get", "arm"}).at("robots").at(0);
  EXPECT_EQ(robot.at("state").at(0), 1.5);
  EXPECT_EQ(robot.at("x_world_base").at("ty_m"), 2.0);
  EXPECT_THAT(Cwm({"rules"}).out, AllOf(HasSubstr("arm:base"), HasSubstr("post")));
  // The floor may touch everything, so no body collides with it; points are not subject to pair
  // rules.
  const json points = CwmJson({"sample", "0,0,-1.5", "0,0,-0.8"}).at("rows");
  EXPECT_EQ(points.at(0).at("distance_m"), -0.5);
  EXPECT_NEAR(points.at(1).at("distance_m").get<double>(), 0.2, 1e-12);
  EXPECT_EQ(
      CwmJson({"check", "--sphere", "0.01", "--at", "5.05,0.05,0.05"}).at("rows")[0].at("verdict"),
      "VERDICT_COLLISION");
}

TEST_F(PlanningSceneCommand, ImportWarnsWhereSceneAndRobotDifferAboutLinks) {
  constexpr char kTwoMore[] =
      R"(<link name="tool"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="wrist" type="revolute"><parent link="hand"/><child link="tool"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint></robot>
)";
  std::string urdf = kUrdf;
  urdf.replace(urdf.find("</robot>"), std::string::npos, kTwoMore);
  std::ofstream(scratch() / "arm.urdf") << urdf;
  std::ofstream(scratch() / "arm.srdf") << R"(<robot name="arm">
<disable_collisions link1="base" link2="hand"/></robot>)";
  CwmJson({"robot", "load", scratch() / "arm.urdf", "--srdf", scratch() / "arm.srdf"});
  const auto import = [&](const std::string& rows) {
    std::ofstream(scratch() / "rules.yaml")
        << "allowed_collision_matrix:\n  entry_names: [base, hand, tool]\n  entry_values: " << rows
        << "\nworld:\n  collision_objects: [{id: post, primitives: [{type: sphere, dimensions: "
           "[0.1]}], "
           "primitive_poses: [{position: [3, 0, 0], orientation: [0, 0, 0, 1]}]}]\n";
    const ProcessResult run = Cwm({"import", scratch() / "rules.yaml"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err;
  };
  EXPECT_THAT(import("[[false, true, false], [true, false, false], [false, false, false]]"),
              Not(HasSubstr("allowed_collision_matrix")));
  EXPECT_THAT(import("[[false, false, true], [false, false, false], [true, false, false]]"),
              AllOf(HasSubstr("false to base with hand, which arm does not check"),
                    HasSubstr("true to base with tool, which arm would check")));
  EXPECT_THAT(Cwm({"rules"}).out, ContainsRegex("arm:base +arm:hand +checked"));
}

TEST_F(PlanningSceneCommand, ImportTakesBackWhatWasAllowedBefore) {
  LoadArm();
  ASSERT_EQ(Cwm({"import", scratch() / "scene.yaml"}).exit_code, 0);
  ASSERT_EQ(Cwm({"allow", "post", "arm:hand"}).exit_code, 0);
  std::string scene = kScene;
  const auto replace = [&](const std::string& part, const std::string& by) {
    scene.replace(scene.find(part), part.size(), by);
  };
  replace("[false, true, true, true]", "[false, true, false, true]");  // base
  replace("[true, false, false, false], [true, false, false, false]]",
          "[false, false, false, false], [true, false, false, false]]");  // post
  replace("default_entry_names: [floor]", "default_entry_names: [ceiling]");
  std::ofstream(scratch() / "second.yaml") << scene;
  const ProcessResult run = Cwm({"import", scratch() / "second.yaml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 rules of pairs withdrawn"));
  EXPECT_THAT(run.err,
              HasSubstr("1 rule of pairs of before, which the scene says nothing of, stays"));
  EXPECT_THAT(Cwm({"rules"}).out,
              AllOf(Not(HasSubstr("post")), HasSubstr("floor"), HasSubstr("arm:hand")));
}

TEST_F(PlanningSceneCommand, ImportReplacesWhatWasPutBefore) {
  LoadArm();
  ASSERT_EQ(Cwm({"import", scratch() / "scene.yaml"}).exit_code, 0);
  ASSERT_EQ(Cwm({"put", "cup", "--sphere", "0.1", "--at", "9,0,0"}).exit_code, 0);
  ASSERT_EQ(Cwm({"put", "dark", "--box", "1,1,1", "--at", "8,0,0", "--unseen"}).exit_code, 0);
  ASSERT_EQ(Cwm({"allow", "cup", "post"}).exit_code, 0);
  std::string scene = kScene;
  scene.replace(scene.find("id: floor"), 9, "id: field");
  std::ofstream(scratch() / "second.yaml") << scene;
  const auto names = [&] {
    std::vector<std::string> all;
    const json listed = CwmJson({"objects"});
    for (const json& object : listed.at("objects")) all.push_back(object.at("name"));
    return all;
  };
  // Without --replace, objects are added to the existing ones.
  ASSERT_EQ(Cwm({"import", scratch() / "second.yaml"}).exit_code, 0);
  EXPECT_THAT(names(), ElementsAre("big_mesh", "cup", "dark", "field", "floor", "post"));
  const std::int64_t revision = Revision();
  const ProcessResult run = Cwm({"import", scratch() / "second.yaml", "--replace"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("2 objects of before removed"),
                             HasSubstr("2 rules of pairs withdrawn")));
  EXPECT_THAT(run.err, Not(HasSubstr("of before")));
  // In one revision, and objects that no import has put remain.
  EXPECT_EQ(Revision(), revision + 1);
  EXPECT_THAT(names(), ElementsAre("big_mesh", "dark", "field", "post"));
  EXPECT_THAT(Cwm({"rules"}).out,
              AllOf(Not(HasSubstr("cup")), Not(HasSubstr("floor")), HasSubstr("arm:base")));
}

TEST_F(PlanningSceneCommand, ImportTakesADifferenceForOne) {
  LoadArm();
  ASSERT_EQ(Cwm({"import", scratch() / "scene.yaml"}).exit_code, 0);
  std::ofstream(scratch() / "difference.yaml") << R"(
is_diff: true
world:
  collision_objects:
    - {id: post, operation: 1}
    - {id: nothing, operation: remove}
    - {id: cup, primitives: [{type: sphere, dimensions: [0.1]}], primitive_poses: [{position: [9, 0, 0], orientation: [0, 0, 0, 1]}]}
)";
  const ProcessResult replaced = Cwm({"import", scratch() / "difference.yaml", "--replace"});
  EXPECT_NE(replaced.exit_code, 0);
  EXPECT_THAT(replaced.err, HasSubstr("is_diff is true"));
  const ProcessResult run = Cwm({"import", scratch() / "difference.yaml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("1 object of before removed"), HasSubstr("1 object")));
  EXPECT_THAT(run.err, HasSubstr("nothing: not removed"));
  EXPECT_THAT(Cwm({"objects"}).out,
              AllOf(HasSubstr("cup"), HasSubstr("floor"), Not(HasSubstr("post"))));
}

TEST_F(PlanningSceneCommand, ImportLeavesOutWhatIsNotWantedOrNotThere) {
  const ProcessResult without_robot = Cwm({"import", scratch() / "scene.yaml"});
  ASSERT_EQ(without_robot.exit_code, 0) << without_robot.err;
  EXPECT_THAT(without_robot.err, HasSubstr("`cwm robot load` it first"));
  EXPECT_THAT(without_robot.out, AllOf(HasSubstr("3 objects"), Not(HasSubstr("state"))));
  LoadArm("second");
  const ProcessResult less = Cwm({"import", scratch() / "scene.yaml", "--world", "second",
                                  "--without", "state", "--without", "allowed"});
  ASSERT_EQ(less.exit_code, 0) << less.err;
  EXPECT_THAT(less.out, AllOf(Not(HasSubstr("state")), Not(HasSubstr("pair"))));
  EXPECT_EQ(CwmJson({"robot", "get", "arm", "--world", "second"}).at("robots")[0].at("state")[0],
            0);
  const ProcessResult unknown =
      Cwm({"import", scratch() / "scene.yaml", "--world", "second", "--robot", "ghost"});
  EXPECT_EQ(unknown.exit_code, 3) << unknown.err;
}

TEST_F(PlanningSceneCommand, ExportIsWhatImportReads) {
  LoadArm();
  ASSERT_EQ(Cwm({"import", scratch() / "scene.yaml"}).exit_code, 0);
  const json said = CwmJson({"export", scratch() / "out.yaml"});
  EXPECT_EQ(said.at("revision"), "2");
  EXPECT_THAT(said.at("warnings").dump(), HasSubstr("floor: a half-space is written as a plane"));
  LoadArm("again");
  const ProcessResult run = Cwm({"import", scratch() / "out.yaml", "--world", "again"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out,
              AllOf(HasSubstr("3 objects"), HasSubstr("its base"), HasSubstr("3 allowed")));
  ASSERT_EQ(Cwm({"export", scratch() / "again.yaml", "--world", "again"}).exit_code, 0);
  EXPECT_EQ(AfterTheName(ContentOf(scratch() / "again.yaml")),
            AfterTheName(ContentOf(scratch() / "out.yaml")));
  const ProcessResult text = Cwm({"export", "-", "--format", "scene"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("* post\n1.5 2 0\n"), HasSubstr("plane\n0 0 1 0\n")));
  EXPECT_THAT(text.err, HasSubstr("robots and rules of pairs: left out"));
  std::ofstream(scratch() / "text.scene") << text.out;
  ASSERT_EQ(Cwm({"import", scratch() / "text.scene", "--world", "third"}).exit_code, 0);
  const ProcessResult third = Cwm({"export", "-", "--format", "scene", "--world", "third"});
  EXPECT_EQ(AfterTheName(third.out), AfterTheName(text.out));
}

TEST_F(PlanningSceneCommand, KeepsWhatTheRobotHolds) {
  LoadArm();
  std::ofstream(scratch() / "held.yaml") << R"(
robot_state:
  joint_state: {name: [shoulder], position: [0]}
  attached_collision_objects:
    - link_name: hand
      touch_links: [base]
      object: {header: {frame_id: hand}, id: can, primitives: [{type: sphere, dimensions: [0.1]}],
               primitive_poses: [{position: [0.6, 0, 0], orientation: [0, 0, 0, 1]}]}
    - link_name: hand
      object: {id: lid, primitives: [{type: sphere, dimensions: [0.1]}],
               primitive_poses: [{position: [0.5, 0, 0.2], orientation: [0, 0, 0, 1]}]}
)";
  const ProcessResult run = Cwm({"import", scratch() / "held.yaml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("2 attached objects"), HasSubstr("revision 2")));
  const auto held = [&](const std::string& name, const std::string& world) {
    return CwmJson({"get", name, "--world", world}).at("object").at("attachment");
  };
  EXPECT_EQ(held("can", "default").at("link"), "hand");
  EXPECT_EQ(held("can", "default").at("touch_links"), json::array({"base"}));
  EXPECT_EQ(held("can", "default").at("x_link_object").at("tx_m"), 0.6);
  EXPECT_EQ(held("lid", "default").at("x_link_object").at("tz_m"), 0.2);
  ASSERT_EQ(Cwm({"export", scratch() / "again.yaml"}).exit_code, 0);
  LoadArm("again");
  ASSERT_EQ(Cwm({"import", scratch() / "again.yaml", "--world", "again"}).exit_code, 0);
  for (const char* name : {"can", "lid"}) EXPECT_EQ(held(name, "again"), held(name, "default"));
  const ProcessResult text = Cwm({"export", "-", "--format", "scene"});
  EXPECT_THAT(text.err, HasSubstr("can: left out, it is attached to arm"));
  const ProcessResult free =
      Cwm({"import", scratch() / "held.yaml", "--world", "again", "--without", "attached"});
  EXPECT_THAT(free.out, Not(HasSubstr("object"))) << free.err;
}

TEST_F(PlanningSceneCommand, ImportGoesOnWithoutLinksThatTheRobotLacks) {
  LoadArm();
  std::ofstream(scratch() / "other.yaml") << R"(
robot_state:
  attached_collision_objects:
    - link_name: hand
      touch_links: [base, thumb]
      object: {id: can, primitives: [{type: sphere, dimensions: [0.1]}],
               primitive_poses: [{position: [0.6, 0, 0], orientation: [0, 0, 0, 1]}]}
    - link_name: gripper
      object: {id: lid, primitives: [{type: sphere, dimensions: [0.1]}],
               primitive_poses: [{position: [0.5, 0, 0.2], orientation: [0, 0, 0, 1]}]}
    - link_name: gripper
      object: {header: {frame_id: gripper}, id: pen,
               primitives: [{type: sphere, dimensions: [0.1]}],
               primitive_poses: [{position: [0.5, 0, 0.2], orientation: [0, 0, 0, 1]}]}
allowed_collision_matrix: {default_entry_names: [base], default_entry_values: [true]}
)";
  const ProcessResult run = Cwm({"import", scratch() / "other.yaml"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, AllOf(HasSubstr("2 objects"), HasSubstr("1 attached object")));
  for (const char* warning :
       {"can: touch_links thumb: left out, arm has no such links",
        "lid: stands free, arm has no link gripper", "pen: left out with its pose in that link"}) {
    EXPECT_THAT(run.err, HasSubstr(warning));
  }
  EXPECT_EQ(CwmJson({"get", "can"}).at("object").at("attachment").at("touch_links"),
            json::array({"base"}));
  const json lid = CwmJson({"get", "lid"}).at("object");
  EXPECT_FALSE(lid.contains("attachment"));
  EXPECT_EQ(lid.at("x_world_object").at("tz_m"), 0.2);
  // A rule about everything needs the robot, of which the file says nothing else.
  EXPECT_THAT(Cwm({"rules"}).out, HasSubstr("arm:base"));
}

TEST_F(PlanningSceneCommand, ExportSaysWhatIsWrong) {
  EXPECT_EQ(Cwm({"export", scratch() / "x.scene"}).exit_code, 3) << "there is no world yet";
  CwmJson({"put", "crate", "--box", "1,1,1"});
  CwmJson({"put", "crate", "--box", "2,1,1"});
  EXPECT_EQ(Cwm({"export", scratch() / "x.obj"}).exit_code, 1);
  EXPECT_EQ(Cwm({"export", scratch() / "x.yaml", "--robot", "ghost"}).exit_code, 3);
  EXPECT_EQ(Cwm({"export", scratch() / "x.yaml", "--at-revision", "9"}).exit_code, 4);
  EXPECT_EQ(Cwm({"export", "/nowhere/x.yaml"}).exit_code, 8);
  const ProcessResult old = Cwm({"export", "-", "--format", "scene", "--at-revision", "1"});
  EXPECT_THAT(old.out, HasSubstr("box\n1 1 1\n"));
  std::ofstream(scratch() / "bad.scene") << "x\n* a\n1\nbox\n1 nan 1\n0 0 0\n0 0 0 1\n0 0 0 0\n.\n";
  const ProcessResult bad = Cwm({"import", scratch() / "bad.scene"});
  EXPECT_EQ(bad.exit_code, 8);
  EXPECT_THAT(bad.err, HasSubstr("bad.scene: line 5: box is nan, must be a finite number"));
}

// Compares the Panda's verdicts for the same random states in both worlds.
TEST_F(PlanningSceneCommand, KeepsEveryFamilyOfProblemsAsThePandaSeesIt) {
  const auto panda = OutsideData("motion_bench_maker/panda");
  if (!panda) GTEST_SKIP() << "planning scenes (motion_bench_maker) are not in CWM_DATA";
  std::mt19937 random(1);
  std::uniform_real_distribution<double> angle(-2, 2);
  std::ostringstream states;
  for (int i = 0; i < 100; ++i) {
    json joints = json::array();
    for (int k = 0; k < 7; ++k) joints.push_back(k == 3 ? angle(random) / 2 - 1.2 : angle(random));
    states << json{{"joints", joints}} << "\n";
  }
  const auto load = [&](const std::string& world) {
    CwmJson({"robot", "load", *panda + "/panda.urdf", "--srdf", *panda + "/panda.srdf",
             "--package-dir", *panda, "--world", world});
  };
  const auto verdicts = [&](const std::string& world) {
    const json rows = CwmJson({"check", "--robot", "panda", "--group", "panda_arm", "--joints", "-",
                               "--world", world},
                              states.str())
                          .at("rows");
    std::vector<std::string> found;
    for (const json& row : rows) found.push_back(row.at("verdict"));
    return found;
  };
  int families = 0;
  std::ptrdiff_t collisions = 0;
  for (const auto& family : std::filesystem::directory_iterator(*panda + "/problems")) {
    const std::string name = family.path().filename();
    SCOPED_TRACE(name);
    ++families;
    load(name);
    const ProcessResult run = Cwm({"import", family.path() / "scene0001.yaml", "--world", name});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.out, AllOf(HasSubstr("the state of panda (7 joint values and its base)"),
                               HasSubstr("allowed pairs")));
    const std::vector<std::string> before = verdicts(name);
    ASSERT_EQ(before.size(), 100U);
    collisions += std::count(before.begin(), before.end(), "VERDICT_COLLISION");
    for (const char* ending : {".yaml", ".scene"}) {
      const std::string world = name + ending;
      const std::string file = scratch() / world;
      ASSERT_EQ(Cwm({"export", file, "--world", name}).exit_code, 0);
      load(world);
      ASSERT_EQ(Cwm({"import", file, "--world", world}).exit_code, 0);
      EXPECT_EQ(verdicts(world), before) << ending;
      CwmJson({"call", "cwm.v1.WorldService/DeleteWorld", json{{"world", world}}.dump()});
    }
  }
  EXPECT_EQ(families, 7);
  EXPECT_GT(collisions, 70);
  EXPECT_LT(collisions, 690);
}

}  // namespace
}  // namespace cwm::testing
