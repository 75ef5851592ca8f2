// `cwm robot` as a user types it.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/e2e/server_fixture.h"
#include "tests/support/outside_data.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr char kTetrahedron[] =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
constexpr char kUrdf[] = R"(<robot name="crane">
<link name="base"><collision><geometry><mesh filename="package://crane/base.obj"/></geometry></collision></link>
<link name="boom"><collision><geometry><mesh filename="boom.obj"/></geometry></collision></link>
<joint name="swing" type="revolute"><parent link="base"/><child link="boom"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="2"/></joint></robot>
)";

class RobotCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    // packages/crane/base.obj, packages/crane/urdf/{crane.urdf,boom.obj}
    std::filesystem::create_directories(scratch() / "packages/crane/urdf");
    std::ofstream(scratch() / "packages/crane/base.obj") << kTetrahedron;
    std::ofstream(scratch() / "packages/crane/urdf/boom.obj") << kTetrahedron;
    std::ofstream(urdf()) << kUrdf;
  }
  std::string urdf() const { return scratch() / "packages/crane/urdf/crane.urdf"; }
};

TEST_F(RobotCommand, LoadsListsShowsAndRemovesARobot) {
  const json loaded = CwmJson({"robot", "load", urdf(), "--at", "1,2,3"});
  EXPECT_EQ(loaded.at("revision"), "1");
  EXPECT_EQ(loaded.at("robot").at("name"), "crane");
  EXPECT_EQ(loaded.at("robot").at("x_world_base").at("ty_m"), 2.0);
  EXPECT_EQ(loaded.at("robot").at("links").at(0).at("triangle_count"), "4");
  EXPECT_EQ(loaded.at("warnings").size(), 1u);
  CwmJson({"robot", "load", urdf(), "--name", "another"});
  EXPECT_EQ(CwmJson({"robot", "list"}).at("robots").size(), 2u);
  const std::string lines = Cwm({"-o", "ndjson", "robot", "list"}).out;
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 2) << lines;
  const json shown = CwmJson({"robot", "get", "crane"});
  ASSERT_EQ(shown.at("robots").size(), 1u);
  EXPECT_EQ(shown["robots"][0].at("variables").at(0).at("upper"), 2.0);
  EXPECT_EQ(CwmJson({"robot", "remove", "crane"}).at("revision"), "3");
  EXPECT_EQ(CwmJson({"robot", "list"}).at("robots").size(), 1u);
}

TEST_F(RobotCommand, LoadsPaddingsScalesAndTools) {
  const ProcessResult loaded = Cwm({"robot", "load", urdf(), "--padding", "boom=0.02", "--scale",
                                    "*=0.5", "--tool", "hook=boom@0,0,-0.5", "--tool", "top=boom"});
  EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  EXPECT_THAT(loaded.out, AllOf(HasSubstr("PADDING"), HasSubstr("20.0 mm"), HasSubstr("0.500")));
  EXPECT_THAT(loaded.out, AllOf(HasSubstr("TOOL"), HasSubstr("hook"), HasSubstr("-0.500")));
  const json shown = CwmJson({"robot", "get", "crane"})["robots"][0];
  EXPECT_EQ(shown.at("tools").at(0).at("link"), "boom");
  EXPECT_EQ(shown.at("links").at(1).at("padding_m"), 0.02);
  const json solved = CwmJson({"solve", "--robot", "crane", "--tool", "hook", "--at", "0,0,-0.5"});
  EXPECT_EQ(solved.at("rows")[0].at("status"), "POSE_STATUS_SOLVED");
  const auto fails = [&](std::vector<std::string> more, const std::string& what) {
    std::vector<std::string> words = {"robot", "load", urdf()};
    words.insert(words.end(), more.begin(), more.end());
    const ProcessResult run = Cwm(words);
    EXPECT_NE(run.exit_code, 0);
    EXPECT_THAT(run.err, HasSubstr(what));
  };
  fails({"--padding", "boom"}, "--padding: \"boom\" must be LINK=METRES");
  fails({"--scale", "boom=big"}, "must be LINK=FACTOR");
  fails({"--tool", "hook"}, "must be NAME=LINK[@X,Y,Z");
  fails({"--tool-group", "hook=arm"}, "must be the name of a --tool");
  fails({"--padding", "jib=0.1"}, "must be a link of robot");
}

TEST_F(RobotCommand, ListsAllContactsOfTheWorld) {
  CwmJson({"put", "cup", "--sphere", "0.1", "--at", "5,0,0"});
  CwmJson({"put", "tray", "--box", "1,1,0.2", "--at", "5,0,-0.15"});
  CwmJson({"robot", "load", urdf()});
  const ProcessResult all = Cwm({"contacts", "--all"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
  EXPECT_THAT(all.out, AllOf(HasSubstr("cup"), HasSubstr("tray"), HasSubstr("-50.000")));
  EXPECT_THAT(all.out, HasSubstr("1 contact\n"));
  EXPECT_THAT(Cwm({"contacts", "--all", "--ignore", "cup"}).out, HasSubstr("0 contacts\n"));
  const ProcessResult both = Cwm({"contacts", "--all", "--object", "cup"});
  EXPECT_NE(both.exit_code, 0);
  EXPECT_THAT(both.err, HasSubstr("--all: not together with a body"));
}

TEST_F(RobotCommand, ShowsTablesToPeople) {
  const ProcessResult loaded = Cwm({"robot", "load", urdf()});
  EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  EXPECT_THAT(loaded.out, HasSubstr("crane"));
  EXPECT_THAT(loaded.out, HasSubstr("swing"));
  EXPECT_THAT(loaded.out, HasSubstr("revolute"));
  EXPECT_THAT(loaded.err, HasSubstr("no SRDF was given"));
  EXPECT_THAT(Cwm({"robot", "list"}).out, HasSubstr("crane"));
  EXPECT_THAT(Cwm({"watch", "--once"}).out, HasSubstr("robot of 2 links"));
}

TEST_F(RobotCommand, SetsWhereARobotStands) {
  const std::string srdf = scratch() / "crane.srdf";
  std::ofstream(srdf) << R"(<robot name="crane"><group name="arm"><joint name="swing"/></group>
    <group_state name="out" group="arm"><joint name="swing" value="1.5"/></group_state></robot>)";
  ASSERT_EQ(Cwm({"robot", "load", urdf(), "--srdf", srdf}).exit_code, 0);
  const auto crane = [&] { return CwmJson({"robot", "get", "crane"}).at("robots").at(0); };
  EXPECT_EQ(CwmJson({"robot", "set", "crane", "--joints", "out"}).at("revision"), "2");
  EXPECT_EQ(crane().at("state").at(0), 1.5);
  EXPECT_THAT(Cwm({"robot", "set", "crane", "--at", "0,0,1"}).out,
              HasSubstr("set crane, revision 3"));
  EXPECT_EQ(crane().at("state").at(0), 1.5) << "what is not given stays";
  EXPECT_EQ(crane().at("x_world_base").at("tz_m"), 1.0);
  EXPECT_EQ(Cwm({"robot", "set", "crane", "--group", "arm", "--joints=-0.5"}).exit_code, 0);
  EXPECT_EQ(crane().at("state").at(0), -0.5);

  EXPECT_EQ(Cwm({"robot", "set", "crane"}).exit_code, 1);
  const ProcessResult wide = Cwm({"robot", "set", "crane", "--joints", "1,2"});
  EXPECT_EQ(wide.exit_code, 1);
  EXPECT_THAT(wide.err, HasSubstr("--joints has 2 numbers, must be 1: swing"));
  EXPECT_THAT(Cwm({"robot", "set", "crane", "--joints", "inn"}).err, HasSubstr("out"));
  const ProcessResult leg = Cwm({"robot", "set", "crane", "--group", "leg", "--joints", "0"});
  EXPECT_EQ(leg.exit_code, 3);
  EXPECT_THAT(leg.err, HasSubstr("no group \"leg\" of \"crane\": arm"));
  EXPECT_EQ(Cwm({"robot", "set", "ghost", "--joints", "0"}).exit_code, 3);
  EXPECT_EQ(Cwm({"robot", "set", "crane", "--joints", "0", "--expected-revision", "1"}).exit_code,
            4);
  EXPECT_EQ(crane().at("state").at(0), -0.5);
}

TEST_F(RobotCommand, TellsOfNamedStatesThatSayNothing) {
  const std::string srdf = scratch() / "crane.srdf";
  std::ofstream(srdf) << R"(<robot name="crane"><group name="hook"><link name="base"/></group>
    <group_state name="open" group="hook"><joint name="swing" value="1"/></group_state></robot>)";
  const ProcessResult loaded = Cwm({"robot", "load", urdf(), "--srdf", srdf});
  EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
  EXPECT_THAT(loaded.err, HasSubstr("group_state \"open\": joint \"swing\" is not one of group"));
  const ProcessResult finished =
      Cwm({"check", "--robot", "crane", "--group", "hook", "--joints", "open"});
  EXPECT_EQ(finished.exit_code, 1);
  EXPECT_THAT(finished.err, HasSubstr("\"open\" says nothing that joints of hook can take"));
}

TEST_F(RobotCommand, SaysByItsExitCodeWhatWentWrong) {
  EXPECT_EQ(Cwm({"robot"}).exit_code, 1);
  EXPECT_EQ(Cwm({"robot", "load"}).exit_code, 1);
  EXPECT_EQ(Cwm({"robot", "list"}).exit_code, 3) << "there is no world yet";
  EXPECT_EQ(Cwm({"robot", "load", "/nowhere.urdf"}).exit_code, 8);
  ASSERT_EQ(Cwm({"robot", "load", urdf()}).exit_code, 0);
  const ProcessResult unknown = Cwm({"robot", "get", "ghost"});
  EXPECT_EQ(unknown.exit_code, 3);
  EXPECT_THAT(unknown.err, HasSubstr("ROBOT_UNKNOWN"));
  EXPECT_THAT(unknown.err, HasSubstr("hint: `cwm robot list`"));
  EXPECT_EQ(Cwm({"robot", "remove", "ghost"}).exit_code, 3);
  EXPECT_EQ(Cwm({"robot", "remove", "crane", "--expected-revision", "9"}).exit_code, 4);
  std::ofstream(scratch() / "bad.urdf") << "<robot name=\"r\"><link/></robot>";
  const ProcessResult bad = Cwm({"robot", "load", scratch() / "bad.urdf"});
  EXPECT_EQ(bad.exit_code, 8);
  EXPECT_THAT(bad.err, HasSubstr("link"));
}

TEST_F(RobotCommand, LooksForMeshesInPackages) {
  const std::string alone = scratch() / "alone.urdf";
  std::filesystem::copy_file(urdf(), alone);
  std::filesystem::copy_file(scratch() / "packages/crane/urdf/boom.obj", scratch() / "boom.obj");
  const ProcessResult lost = Cwm({"robot", "load", alone});
  EXPECT_EQ(lost.exit_code, 8);
  EXPECT_THAT(lost.err, HasSubstr("package://crane/base.obj"));
  EXPECT_THAT(lost.err, HasSubstr("--package-dir"));
  const ProcessResult found = Cwm({"robot", "load", alone, "--package-dir", scratch() / "nothing",
                                   "--package-dir", scratch() / "packages"});
  EXPECT_EQ(found.exit_code, 0) << found.err;
}

TEST_F(RobotCommand, LoadsThePandaOfMotionBenchMaker) {
  const auto panda = OutsideData("motion_bench_maker/panda");
  if (!panda) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
  const json loaded =
      CwmJson({"robot", "load", *panda + "/panda.urdf", "--srdf", *panda + "/panda.srdf",
               "--spheres", *panda + "/panda_spherized.urdf", "--package-dir", *panda});
  const json& robot = loaded.at("robot");
  EXPECT_EQ(robot.at("name"), "panda");
  EXPECT_EQ(robot.at("links").size(), 13u);
  EXPECT_EQ(robot.at("variables").size(), 7u);
  int with_shapes = 0, spheres = 0;
  for (const json& link : robot["links"]) {
    with_shapes += link.at("collision_count").get<int>() > 0 ? 1 : 0;
    spheres += link.at("sphere_count").get<int>();
  }
  EXPECT_EQ(with_shapes, 11);
  EXPECT_EQ(spheres, 59);
  EXPECT_THAT(loaded.at("warnings").dump(), HasSubstr("open mesh"));
  EXPECT_THAT(Cwm({"robot", "get", "panda"}).out, HasSubstr("panda_arm"));
}

}  // namespace
}  // namespace cwm::testing
