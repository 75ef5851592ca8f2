#include "server/core/load_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "tests/collision/mesh_files/expanding_collada.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::testing::Arm;
using collision::testing::ArmSrdf;
using collision::testing::ArmUrdf;
using collision::testing::JointText;
using collision::testing::Links;
using collision::testing::PutArm;
using collision::testing::Robot;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr char kTetrahedron[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
constexpr char kTriangle[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

std::string MeshLink(const std::string& name, const std::string& uri) {
  return "<link name=\"" + name + "\"><collision><geometry><mesh filename=\"" + uri +
         "\"/></geometry></collision></link>\n";
}

absl::Status Refusal(RobotFiles files, const collision::RobotLimits& limits = {}) {
  return ReadRobot(std::move(files), limits, {}).status();
}

void ExpectField(const absl::Status& status, const std::string& field, const std::string& rule) {
  const ErrorDetails details = DetailsOf(status);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << status;
  EXPECT_EQ(details.reason, "INVALID_FIELD");
  ASSERT_EQ(details.fields.size(), 1u);
  EXPECT_EQ(details.fields[0].field, field);
  EXPECT_THAT(details.fields[0].description, HasSubstr(rule));
}

TEST(ReadRobot, ReadsEachFileForItsPart) {
  RobotFiles files{.urdf = Robot(MeshLink("a", "package://p/a.obj") + MeshLink("b", "b.obj") +
                                 JointText("j", "revolute", "a", "b"))};
  files.srdf = "<robot name=\"r\"><group name=\"g\"><joint name=\"j\"/></group></robot>";
  files.spheres = Robot(collision::testing::Ball("a"));
  files.meshes = {{"package://p/a.obj", kTetrahedron}, {"b.obj", kTetrahedron}};
  const auto robot = ReadRobot(files, {}, {});
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_EQ((*robot)->geometry->parts.size(), 2u);
  EXPECT_NE((*robot)->model->FindGroup("g"), nullptr);
  ASSERT_TRUE((*robot)->spheres_as_given.has_value());
  EXPECT_EQ((*robot)->spheres_as_given->links[0].size(), 1u);
}

TEST(ReadRobot, NamesTheFileThePlaceAndTheRule) {
  ExpectField(Refusal({.urdf = Robot(MeshLink("hand", "package://p/hand.stl"))}), "header.urdf",
              "link \"hand\": collision: geometry: mesh filename is \"package://p/hand.stl\": must "
              "be one of the files sent along");
  ExpectField(Refusal({.urdf = "<robot"}), "header.urdf", "");
  ExpectField(Refusal({.urdf = Robot(Links("ab") + JointText("j", "fixed", "a", "b") +
                                     JointText("k", "fixed", "b", "a"))}),
              "header.urdf", "");
  ExpectField(Refusal({.urdf = Robot(Links("ab") + JointText("j", "revolute", "a", "b", ""))}),
              "header.urdf", "limit");
  ExpectField(Refusal({.urdf = Robot(Links("ab") + JointText("j", "fixed", "a", "b",
                                                             "<origin xyz=\"nan 0 0\"/>"))}),
              "header.urdf", "nan");
  ExpectField(Refusal({.urdf = "<!DOCTYPE r [<!ENTITY a \"&b;&b;\"><!ENTITY b \"bang\">]>"
                               "<robot name=\"&a;\"/>"}),
              "header.urdf", "must not have a DOCTYPE");
  ExpectField(Refusal({.urdf = ArmUrdf(), .srdf = ArmSrdf("nan")}), "header.srdf", "nan");
  ExpectField(Refusal({.urdf = ArmUrdf(),
                       .srdf = "<robot name=\"arm\"><group name=\"ghost\"/>"
                               "<group name=\"ghost\"/></robot>"}),
              "header.srdf", "ghost");
  ExpectField(Refusal({.urdf = ArmUrdf(), .spheres = Robot(Links("z"))}), "header.spheres",
              "must be a link");
}

TEST(ReadRobot, SaysWhichLimitIsTooSmall) {
  const auto expect = [](RobotFiles files, const collision::RobotLimits& limits,
                         const std::string& rule) {
    const absl::Status status = Refusal(std::move(files), limits);
    EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(DetailsOf(status).reason, "ROBOT_TOO_LARGE");
    EXPECT_THAT(std::string(status.message()), HasSubstr(rule));
  };
  expect({.urdf = ArmUrdf()}, {.max_links = 6}, "at most 6 links");
  expect({.urdf = ArmUrdf()}, {.max_xml_bytes = 100}, "at most 100");
  expect({.urdf = ArmUrdf(), .srdf = ArmSrdf()}, {.max_groups = 0}, "at most 0");
  const RobotFiles mesh{.urdf = Robot(MeshLink("a", "a.obj")), .meshes = {{"a.obj", kTetrahedron}}};
  expect(mesh, {.mesh_file = {.max_bytes = 10}}, "at most 10");
  expect(mesh, {.mesh_file = {.max_triangles = 3}}, "at most 3 triangles");
  expect(mesh, {.max_triangles = 3}, "at most 3 triangles together");
}

// A file of 3.3 kB that expands to 700 MB: 2^15 uses of a tetrahedron, at two scales.
TEST(ReadRobot, RefusesASmallMeshFileThatBecomesLarge) {
  const auto mesh = [](const std::string& scale) {
    return "<collision><geometry><mesh filename=\"a.dae\" scale=\"" + scale +
           "\"/></geometry></collision>";
  };
  const RobotFiles files{
      .urdf = Robot("<link name=\"a\">" + mesh("1 1 1") + mesh("2 2 2") + "</link>"),
      .meshes = {{"a.dae", collision::testing::ExpandingCollada()}}};
  const absl::Status status = Refusal(files);
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(DetailsOf(status).reason, "ROBOT_TOO_LARGE");
  EXPECT_THAT(std::string(status.message()), HasSubstr("\"a.dae\": must have at most 12"));
}

// Each copy is within the limits of a file, but the second one exceeds those of the robot.
TEST(ReadRobot, RefusesScaledCopiesOfAMeshThatTogetherBecomeLarge) {
  std::string triangles = "v 0 0 0\nv 1 0 0\nv 0 1 0\n", copies;
  for (int i = 0; i < 10'000; ++i) triangles += "f 1 2 3\n";
  for (int i = 1; i <= 20; ++i) {
    copies += "<collision><geometry><mesh filename=\"a.obj\" scale=\"1 1 " + std::to_string(i) +
              "\"/></geometry></collision>";
  }
  const absl::Status status = Refusal(
      {.urdf = Robot("<link name=\"a\">" + copies + "</link>"), .meshes = {{"a.obj", triangles}}});
  EXPECT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
  EXPECT_EQ(DetailsOf(status).reason, "ROBOT_TOO_LARGE");
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("bytes once it is prepared, must take at most"));
}

TEST(ReadRobot, EndsWhenItIsStopped) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(
      ReadRobot({.urdf = Robot(MeshLink("a", "a.obj"))}, {}, stop.get_token()).status().code(),
      absl::StatusCode::kCancelled);
  EXPECT_EQ(ReadRobot({.urdf = ArmUrdf()}, {}, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

// The warnings of a robot in its default state.
std::vector<std::string> WarningsOf(const collision::RobotGeometry& robot, bool has_srdf) {
  return server::WarningsOf(robot, has_srdf, collision::DefaultVariables(*robot.model));
}

TEST(WarningsOfARobot, TellWhatAnswersDependOn) {
  EXPECT_THAT(
      WarningsOf(*Arm(), true),
      ElementsAre("pair base with upper always in collision, in each of the sampled states: "
                  "no state is free; add <disable_collisions> to the SRDF, or allow the "
                  "links to collide",
                  "links fore, left, right, free without collision geometry: never in "
                  "collision; add a <collision> if it has a body"));
  RobotFiles files{.urdf = Robot(MeshLink("a", "a.obj") + MeshLink("b", "b.obj") +
                                 JointText("j", "fixed", "a", "b")),
                   .meshes = {{"a.obj", kTetrahedron}, {"b.obj", kTriangle}}};
  const auto robot = ReadRobot(files, {}, {});
  ASSERT_TRUE(robot.ok()) << robot.status();
  EXPECT_THAT(WarningsOf(**robot, true),
              ElementsAre("link b with an open mesh: surfaces alone, without an inside; close the "
                          "mesh"));
  EXPECT_EQ(WarningsOf(**robot, false).size(), 2u);
  // A cube with a vertex 1 mm beside an edge on one side of it only.
  constexpr char kCrackedCube[] =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 0.5 0.001 0\n"
      "f 1 4 3\nf 1 3 9\nf 3 2 9\nf 5 6 7\nf 5 7 8\nf 1 2 6\nf 1 6 5\nf 2 3 7\nf 2 7 6\nf 3 4 8\n"
      "f 3 8 7\nf 4 1 5\nf 4 5 8\n";
  const auto cracked = ReadRobot(
      {.urdf = Robot(MeshLink("a", "a.obj")), .meshes = {{"a.obj", kCrackedCube}}}, {}, {});
  ASSERT_TRUE(cracked.ok()) << cracked.status();
  EXPECT_THAT(WarningsOf(**cracked, true),
              ElementsAre("link a (a hole of 1000.0 mm) with holes in a mesh that were closed: "
                          "answers near them are BOUNDED"));
  EXPECT_THAT(
      WarningsOf(*Arm(ArmUrdf(), "<robot name=\"arm\"><group name=\"none\"/></robot>"), true),
      Contains("group none without a joint that moves: there is one state of it"));
  EXPECT_EQ(
      WarningsOf(*Arm(ArmUrdf(), "<robot name=\"arm\"><passive_joint name=\"gone\"/></robot>"),
                 true)[0],
      "srdf: passive_joint \"gone\" name is \"gone\": must be a joint of the robot; left out");
}

TEST(WarningsOfARobot, TellOfNamedStatesOutOfLimits) {
  EXPECT_EQ(WarningsOf(*Arm(ArmUrdf(), ArmSrdf("1")), true).size(), 2u) << "at the limit is within";
  EXPECT_EQ(WarningsOf(*Arm(ArmUrdf(), ArmSrdf("1.5")), true)[0],
            "named state ready of reach (elbow is 1.5, must be from -1 to 1) out of limits: the "
            "verdict about such a state is OUT_OF_LIMITS; correct it");
  const std::string still =
      "<robot name=\"arm\"><group name=\"g\"><joint name=\"float\"/></group><group_state "
      "name=\"s\" "
      "group=\"g\"><joint name=\"float\" value=\"0 0 0 0 0 0 0.5\"/></group_state></robot>";
  EXPECT_THAT(WarningsOf(*Arm(ArmUrdf(), still), true)[0],
              HasSubstr("s of g (float/rot_x is 0, must be of a quaternion of length 1)"));
}

TEST(WarningsOfARobot, TellWhatTheLimitsOfFollowersDo) {
  const auto arm_with = [](const std::string& other) {
    std::string urdf = ArmUrdf();
    const std::string limits = "<limit lower=\"-0.04\" upper=\"0\"/>";
    return Arm(urdf.replace(urdf.find(limits), limits.size(), other));
  };
  EXPECT_EQ(WarningsOf(*arm_with("<limit lower=\"-0.02\" upper=\"0\"/>"), true)[0],
            "joint other with limits that narrow those of the joint it follows");
  EXPECT_EQ(WarningsOf(*arm_with("<limit effort=\"10\"/>"), true)[0],
            "joint other with limits that contradict those of the joint it follows: not kept; "
            "correct them");
}

TEST(LoadRobot, MakesOneRevisionAndNoneTheSecondTime) {
  World world{"w", "uid", {}};
  const auto first = LoadRobot(world, PutArm("arm"), {}, {});
  ASSERT_TRUE(first.ok()) << first.status();
  EXPECT_EQ(first->revision.value, 1);
  EXPECT_EQ(LoadRobot(world, PutArm("arm"), {}, {})->revision.value, 1);
  EXPECT_EQ(RemoveRobot(world, "arm", {})->revision.value, 2);
  EXPECT_EQ(DetailsOf(RemoveRobot(world, "arm", {}).status()).reason, "ROBOT_UNKNOWN");
}

TEST(LoadRobot, RefusesTheNameOfAnObjectAndTooManyRobots) {
  World world{"w", "uid", {}};
  ASSERT_TRUE(world.Apply(std::vector{Put("crate")}, {}).ok());
  ExpectField(LoadRobot(world, PutArm("crate"), {}, {}).status(), "header.name", "object");
  Limits limits;
  limits.max_robots = 1;
  ASSERT_TRUE(LoadRobot(world, PutArm("arm"), {}, limits).ok());
  const auto second = LoadRobot(world, PutArm("leg"), {}, limits);
  EXPECT_EQ(second.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_THAT(std::string(second.status().message()), HasSubstr("max_robots"));
  EXPECT_TRUE(LoadRobot(world, PutArm("arm", Arm(ArmUrdf("arm", "0.2"))), {}, limits).ok())
      << "one that takes the place of another";
}

}  // namespace
}  // namespace cwm::server
