// cwm-plan as a user types it, with a two-joint robot whose paths can be checked by hand.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "clients/planner/server_checker.h"
#include "cwm/client.h"
#include "tests/e2e/server_fixture.h"
#include "tests/e2e/two_link_arm.h"
#include "tests/support/outside_data.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr char kSrdf[] =
    R"(<robot name="arm"><group name="both"><joint name="shoulder"/><joint name="elbow"/></group>
<group name="wrist"><joint name="elbow"/></group>
<group_state name="left" group="both">
<joint name="shoulder" value="1"/><joint name="elbow" value="0"/></group_state>
<group_state name="right" group="both">
<joint name="shoulder" value="-1"/><joint name="elbow" value="0"/></group_state></robot>
)";

constexpr char kRequest[] = R"(group_name: both
start_state: {joint_state: {name: [shoulder, elbow], position: [1, 0]}}
goal_constraints:
  - joint_constraints:
    - {joint_name: shoulder, position: -1}
    - {joint_name: elbow, position: 0}
)";

double Clamped(double value) { return std::clamp(value, -0.1, 0.1); }

// The distance of the hand's ball from a box of 0.2 m at (1, 0, 0), in closed form.
double HandFromPost_m(double shoulder, double elbow) {
  const double x = 0.5 * std::cos(shoulder) + 0.5 * std::cos(shoulder + elbow) - 1;
  const double y = 0.5 * std::sin(shoulder) + 0.5 * std::sin(shoulder + elbow);
  return std::hypot(x - Clamped(x), y - Clamped(y)) - 0.1;
}

// The arm is extended along x; a box surrounds its hand.
class PlanCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    Write("arm.urdf", kTwoLinkArm);
    Write("arm.srdf", kSrdf);
    CwmJson({"robot", "load", scratch() / "arm.urdf", "--srdf", scratch() / "arm.srdf"});
    CwmJson({"put", "post", "--box", "0.2,0.2,0.2", "--at", "1,0,0"});
  }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(scratch() / name) << text;
    return scratch() / name;
  }
  ProcessResult Plan(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {Program("cwm-plan"), "--addr", address()});
    return RunProgram(arguments);
  }
  json PlanJson(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"-o", "json"});
    const ProcessResult run = Plan(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out, nullptr, /*allow_exceptions=*/false);
  }
};

TEST_F(PlanCommand, GoesAroundWhatIsInTheWay) {
  const json plan = PlanJson({"--group", "both", "--start", "left", "--goal", "right"});
  EXPECT_EQ(plan.at("outcome"), "SOLVED");
  EXPECT_EQ(plan.at("joints"), json({"shoulder", "elbow"}));
  const json& path = plan.at("path");
  EXPECT_EQ(path.front(), json({1.0, 0.0}));
  EXPECT_EQ(path.back(), json({-1.0, 0.0}));
  // The hand at 1 m, moved by both joints, moves at most this far between states 0.01 rad apart.
  constexpr double kBetweenStates_m = 0.01 / 2 * 1.5;
  double length = 0;
  for (std::size_t k = 1; k < path.size(); ++k) {
    const auto a = path[k - 1].get<std::array<double, 2>>();
    const auto b = path[k].get<std::array<double, 2>>();
    length += std::hypot(b[0] - a[0], b[1] - a[1]);
    for (double t = 0; t <= 1; t += 1e-3) {
      EXPECT_GT(HandFromPost_m(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])),
                -kBetweenStates_m);
    }
  }
  EXPECT_GT(length, 2) << "the straight way is blocked";
  EXPECT_LT(length, 5) << "folding the elbow and back is at most 2 * 1.5 rad more";
  EXPECT_NEAR(plan.at("length").get<double>(), length, 1e-9);
  EXPECT_GE(plan.at("found_length").get<double>(), plan.at("length").get<double>() - 1e-9);
  EXPECT_GT(plan.at("states").get<int>(), 20 * plan.at("batches").get<int>())
      << "states are asked in batches";
}

TEST_F(PlanCommand, PlansTheSameForTheSameSeed) {
  const std::vector<std::string> base = {"--group", "both",  "--start", "left",
                                         "--goal",  "right", "--seed"};
  const auto path = [&](const std::string& seed) {
    std::vector<std::string> arguments = base;
    arguments.push_back(seed);
    return PlanJson(arguments).at("path");
  };
  EXPECT_EQ(path("7"), path("7"));
  EXPECT_NE(path("7"), path("8"));
}

TEST_F(PlanCommand, ShowsThePathToPeople) {
  const ProcessResult run =
      Plan({"--group", "both", "--start", "left", "--goal=1.5,0.25", "--certify"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  for (const char* text : {"shoulder", "1.5000", "length 0.559", "certified: FREE", "batches of"}) {
    EXPECT_THAT(run.out, HasSubstr(text));
  }
  EXPECT_EQ(run.err, "");
}

TEST_F(PlanCommand, SaysWhatIsWrongWithTheEnds) {
  struct Case {
    std::vector<std::string> ends;
    int exit_code;
    std::string says;
  };
  const std::vector<Case> cases = {
      {{"--goal", "left"}, 10, "start in collision: hand meets post"},
      {{"--start", "left", "--goal", "0,0"}, 11, "goal in collision: hand meets post"},
      {{"--start", "1,3", "--goal", "left"},
       10,
       "start in collision: base meets hand of the robot"},
      {{"--start", "3.5,0", "--goal", "left"},
       12,
       "start out of limits: shoulder is 3.5, must be -3 to 3"},
      {{"--start", "left", "--goal=0,-3.01"},
       13,
       "goal out of limits: elbow is -3.01, must be -3 to 3"},
      {{"--start", "left", "--goal", "nowhere"}, 1, "or a named state: left, right"},
      {{"--start", "left", "--goal", "1,2,3"}, 1, "2 numbers"},
      {{"--start", "left"}, 1, "--goal or --goal-at, or a request with a goal, must be given"},
      {{"--start", "left", "--goal", "nan,0"}, 8, "goal: shoulder is nan, must be finite"},
      {{"--start", "left", "--goal", "right", "--time", "0"},
       1,
       "--time is 0, must be more than 0"},
      {{"--start", "left", "--goal", "right", "--range", "nan"}, 1, "--range is nan"},
      {{"--start", "left", "--goal", "right", "--robot", "ghost"}, 3, "no robot \"ghost\""},
      {{"--start", "left", "--goal", "right", "--world", "ghost"}, 3, "ghost"},
      {{"--start", "left", "--goal", "right", "--group", "leg"},
       8,
       "group is \"leg\", must be one of arm: both, wrist"},
      {{scratch() / "absent.yaml"}, 8, "absent.yaml"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> arguments = c.ends;
    if (std::count(arguments.begin(), arguments.end(), "--group") == 0) {
      arguments.insert(arguments.begin(), {"--group", "both"});
    }
    const ProcessResult run = Plan(arguments);
    EXPECT_EQ(run.exit_code, c.exit_code) << c.says << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr(c.says));
  }
}

// Three links in the plane, the last of 0.2 m with the ball of the hand at its end.
constexpr char kThreeLinkArm[] = R"(<robot name="plane"><link name="base"/>
<link name="upper"/><link name="fore"/>
<link name="hand"><collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.02"/></geometry>
</collision></link>
<joint name="one" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint>
<joint name="two" type="revolute"><parent link="upper"/><child link="fore"/><origin xyz="0.5 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint>
<joint name="three" type="revolute"><parent link="fore"/><child link="hand"/><origin xyz="0.5 0 0"/>
<axis xyz="0 0 1"/><limit lower="-3" upper="3"/></joint></robot>
)";
constexpr char kThreeLinkSrdf[] = R"(<robot name="plane"><group name="arm">
<joint name="one"/><joint name="two"/><joint name="three"/></group></robot>
)";

// Where the hand's ball is, and how it is turned.
std::array<double, 3> HandOf(const json& row) {
  const auto q = row.get<std::array<double, 3>>();
  const double a = q[0], b = a + q[1], c = b + q[2];
  return {0.5 * std::cos(a) + 0.5 * std::cos(b) + 0.2 * std::cos(c),
          0.5 * std::sin(a) + 0.5 * std::sin(b) + 0.2 * std::sin(c), c};
}

TEST_F(PlanCommand, PlansToAPoseOfTheToolByWhicheverStateCanBeReached) {
  const std::string urdf = Write("plane.urdf", kThreeLinkArm);
  const std::string srdf = Write("plane.srdf", kThreeLinkSrdf);
  CwmJson({"robot", "load", urdf, "--srdf", srdf, "--world", "plane"});
  CwmJson({"put", "cup", "--sphere", "0.01", "--at", "0.9,0,0.5", "--world", "plane"});
  const std::vector<std::string> base = {"--world", "plane",         "--group",
                                         "arm",     "--x-link-tool", "0.2,0,0"};
  const auto plan = [&](std::vector<std::string> more) {
    more.insert(more.begin(), base.begin(), base.end());
    return PlanJson(more);
  };
  // The elbow can be on either side: the side on which the start is, is nearer.
  for (const char* start : {"--start=0.3,-0.4,0.1", "--start=-0.3,0.4,-0.1"}) {
    const json found = plan({start, "--goal-at", "0.9,0,0"});
    EXPECT_EQ(found.at("outcome"), "SOLVED");
    EXPECT_EQ(found.at("tool_link"), "hand");
    EXPECT_EQ(found.at("goal_states"), 2) << "elbow left and right";
    const json& end = found.at("path").back();
    const auto hand = HandOf(end);
    EXPECT_NEAR(hand[0], 0.9, 2e-6);
    EXPECT_NEAR(hand[1], 0, 2e-6);
    EXPECT_NEAR(hand[2], 0, 2e-6);
    EXPECT_EQ(end[1].get<double>() < 0, start[8] == '0') << "as at the start";
  }
  // By the name of an object, half a metre above the plane of the arm.
  const json above = plan({"--start=0.3,-0.4,0.1", "--goal-at", "cup+0,0,-0.5"});
  EXPECT_NEAR(HandOf(above.at("path").back())[0], 0.9, 2e-6);
  const ProcessResult table =
      Plan({"--world", "plane", "--group", "arm", "--start=0.3,-0.4,0.1", "--x-link-tool",
            "0.2,0,0", "--goal-at", "0.9,0,0", "--certify"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out, HasSubstr("the pose of the tool on hand has 2 free states"));
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string says;
  };
  const std::vector<Case> cases = {
      {{"--goal-at", "2,0,0"}, 16, "goal unreachable: hand is"},
      {{"--goal-at", "0.9,0,0.3"}, 16, "goal unreachable: hand is"},
      {{"--goal-at", "0.9,0,0", "--goal", "0,0,0"}, 1, "excludes"},
      {{"--goal", "0,0,0", "--tool-link", "hand"}, 1, "--tool-link requires --goal-at"},
      {{"--goal-at", "0.9,0"}, 1, "--goal-at"},
      {{"--goal-at", "ghost"}, 3, "ghost"},
      {{"--goal-at", "0.9,0,0", "--tool-link", "leg"}, 8, "leg"},
  };
  for (const Case& c : cases) {
    std::vector<std::string> arguments = {"--world", "plane", "--group", "arm"};
    arguments.insert(arguments.end(), c.arguments.begin(), c.arguments.end());
    const ProcessResult run = Plan(arguments);
    EXPECT_EQ(run.exit_code, c.exit_code) << c.says << ": " << run.err;
    EXPECT_THAT(run.err, HasSubstr(c.says));
  }
  CwmJson({"put", "wall", "--box", "0.3,0.3,0.3", "--at", "0.9,0,0", "--world", "plane"});
  const ProcessResult blocked = Plan({"--world", "plane", "--group", "arm", "--start=1.5,0,0",
                                      "--x-link-tool", "0.2,0,0", "--goal-at", "0.9,0,0"});
  EXPECT_EQ(blocked.exit_code, 11) << blocked.err;
  EXPECT_THAT(blocked.err, HasSubstr("goal in collision: hand meets wall"));
}

// A gate at the elbow that the arm along x cannot pass.
TEST_F(PlanCommand, GivesUpInTimeWhereThereIsNoPath) {
  CwmJson({"put", "gate", "--box", "0.2,0.2,0.2", "--at", "0.5,0,0"});
  const ProcessResult run =
      Plan({"--group", "both", "--start", "left", "--goal", "right", "--time", "0.5"});
  EXPECT_EQ(run.exit_code, 14);
  EXPECT_THAT(run.err, HasSubstr("no path: none was found in 0.5 s"));
}

TEST_F(PlanCommand, TakesRequestsAndRefusesThoseThatAreNone) {
  const json plan = PlanJson({Write("request.yaml", kRequest)});
  EXPECT_EQ(plan.at("group"), "both");
  EXPECT_EQ(plan.at("path").back(), json({-1.0, 0.0}));
  const json other = PlanJson({scratch() / "request.yaml", "--start=1.5,0", "--goal", "left"});
  EXPECT_EQ(other.at("path"), json({{1.5, 0.0}, {1.0, 0.0}})) << "options go before the request";
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = kRequest;
    text.replace(text.find(from), from.size(), to);
    return Plan({Write("bad.yaml", text)});
  };
  const ProcessResult text = refused("position: -1", "position: there");
  EXPECT_EQ(text.exit_code, 8);
  EXPECT_THAT(text.err,
              AllOf(HasSubstr("bad.yaml: goal_constraints[0].joint_constraints[0].position"),
                    HasSubstr("there")));
  EXPECT_THAT(refused("elbow, position: 0", "wing, position: 0").err,
              HasSubstr("elbow is missing"));
  const ProcessResult leg = refused("group_name: both", "group_name: leg");
  EXPECT_EQ(leg.exit_code, 8);
  EXPECT_THAT(leg.err, HasSubstr("must be one of arm: both, wrist"));
}

// The scene's allowed collisions, attached objects and missing objects apply during planning, and
// nothing of it remains.
TEST_F(PlanCommand, PlansInASceneAloneAndLeavesTheWorldAsItIs) {
  const std::string request = Write("request.yaml", kRequest);
  const std::int64_t revision = RevisionOf("default");
  const std::string empty = Write("empty.yaml", "robot_model_name: arm\nrobot_state: {}\n");
  EXPECT_NEAR(PlanJson({request, "--problem", empty}).at("length").get<double>(), 2, 1e-12)
      << "the post is the world's";
  const std::string objects = R"(world:
  collision_objects:
    - id: wall
      primitives: [{type: box, dimensions: [0.2, 0.2, 0.2]}]
      primitive_poses: [{position: [1, 0, 0], orientation: [0, 0, 0, 1]}]
)";
  const std::string scene = "robot_model_name: arm\n" + objects;
  EXPECT_GT(PlanJson({request, "--problem", Write("wall.yaml", scene)}).at("length").get<double>(),
            2.1);
  const std::string allowed = scene +
                              "allowed_collision_matrix:\n  entry_names: [hand, wall]\n"
                              "  entry_values: [[false, true], [true, false]]\n";
  EXPECT_NEAR(
      PlanJson({request, "--problem", Write("allowed.yaml", allowed)}).at("length").get<double>(),
      2, 1e-12);
  const std::string held = scene + R"(robot_state:
  attached_collision_objects:
    - link_name: hand
      touch_links: [hand, upper]
      object:
        id: rod
        header: {frame_id: hand}
        primitives: [{type: box, dimensions: [0.1, 3, 0.1]}]
        primitive_poses: [{position: [0, 0, 0], orientation: [0, 0, 0, 1]}]
)";
  const ProcessResult holds = Plan({request, "--problem", Write("held.yaml", held)});
  EXPECT_EQ(holds.exit_code, 10) << holds.out << holds.err;
  EXPECT_THAT(holds.err, HasSubstr("start in collision: rod meets wall"));
  EXPECT_EQ(RevisionOf("default"), revision);
}

// A needle's tip at 1 m passes a grain. States of the path check 0.005 rad apart are 5 mm apart
// there, and the two overlap for 0.6 mm, between two states.
TEST_F(PlanCommand, DoesNotCallAPathCertifiedThatMeetsSomethingBetweenItsStates) {
  const std::string urdf = Write("needle.urdf", R"(<robot name="needle"><link name="base"/>
<link name="tip"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.0001"/></geometry>
</collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="tip"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint></robot>
)");
  CwmJson({"robot", "load", urdf, "--world", "sewing"});
  // The grain is in the middle of one of the 200 steps from -0.5 to 0.5.
  CwmJson({"put", "grain", "--sphere", "0.0002", "--at", "0.999996875,0.002499997,0", "--world",
           "sewing"});
  const std::vector<std::string> base = {"--world", "sewing", "--start=-0.5", "--goal", "0.5"};
  EXPECT_EQ(PlanJson(base).at("outcome"), "SOLVED") << "its states are free";
  std::vector<std::string> certified = base;
  certified.insert(certified.end(), {"--certify", "-o", "json"});
  const ProcessResult run = Plan(certified);
  EXPECT_EQ(run.exit_code, 15) << run.out << run.err;
  const json certificate = json::parse(run.out).at("certificate");
  EXPECT_EQ(certificate.at("verdict"), "CONTACT");
  EXPECT_EQ(certificate.at("trust"), "EXACT");
  EXPECT_THAT(certificate.dump(), HasSubstr("grain"));
  certified.resize(certified.size() - 2);
  EXPECT_THAT(Plan(certified).out, HasSubstr("tip meets grain"));
}

TEST_F(PlanCommand, TellsOfAServerThatIsGone) {
  const WorldView stream = Connect({.address = address()}).Stream();
  planner::ServerChecker checker({.world = stream, .robot = {.robot = "arm"}});
  const std::vector<double> rows = {1, 0, 0, 0, -1, 0, 3.5, 0};
  const auto free = checker.CheckStates(rows, 2);
  ASSERT_TRUE(free.ok()) << free.status();
  EXPECT_THAT(*free, ::testing::ElementsAre(1, 0, 1, 0));
  const auto width = checker.CheckStates(rows, 1);
  EXPECT_THAT(std::string(width.status().message()), HasSubstr("rows.width: is 1, must be 2"));
  EXPECT_TRUE(checker.CheckStates(rows, 2).ok()) << "the stream goes on";
  const ProcessResult nobody = RunProgram(
      {Program("cwm-plan"), "--addr", "unix:" + scratch() / "nobody.sock", "--goal", "left"});
  EXPECT_EQ(nobody.exit_code, 2);
  EXPECT_THAT(nobody.err, HasSubstr("nobody.sock; start `cwm-server`"));
  planner::ServerChecker ghost({.world = stream, .robot = {.robot = "ghost"}});
  EXPECT_TRUE(absl::IsNotFound(ghost.CheckStates(rows, 2).status()));
}

TEST_F(PlanCommand, SolvesProblemsOfMotionBenchMaker) {
  const auto panda = OutsideData("motion_bench_maker/panda");
  if (!panda) GTEST_SKIP() << "planning problems (motion_bench_maker) are not in CWM_DATA";
  CwmJson({"robot", "load", *panda + "/panda.urdf", "--srdf", *panda + "/panda.srdf",
           "--package-dir", *panda});
  for (const auto& family : std::filesystem::directory_iterator(*panda + "/problems")) {
    const std::string folder = family.path().string();
    const json plan = PlanJson({"--robot", "panda", "--problem", folder + "/scene0011.yaml",
                                folder + "/request0011.yaml"});
    EXPECT_EQ(plan.at("outcome"), "SOLVED") << folder;
    EXPECT_EQ(plan.at("group"), "panda_arm");
    EXPECT_GT(plan.at("path").size(), 1u);
  }
}

}  // namespace
}  // namespace cwm::testing
