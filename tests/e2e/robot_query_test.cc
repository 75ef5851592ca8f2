// Queries about robots and motions, as a user types them.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>

#include "tests/e2e/server_fixture.h"
#include "tests/e2e/two_link_arm.h"
#include "tests/support/outside_data.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr char kSrdf[] =
    R"(<robot name="arm"><group name="both"><joint name="shoulder"/><joint name="elbow"/></group>
<group_state name="aside" group="both">
<joint name="shoulder" value="1.5"/><joint name="elbow" value="0"/></group_state>
<group_state name="bent" group="both">
<joint name="shoulder" value="1.5"/><joint name="elbow" value="3"/></group_state>
</robot>
)";

// The arm is extended along x; a box surrounds its hand.
class RobotQuery : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    std::ofstream(scratch() / "arm.urdf") << kTwoLinkArm;
    std::ofstream(scratch() / "arm.srdf") << kSrdf;
    CwmJson({"robot", "load", scratch() / "arm.urdf", "--srdf", scratch() / "arm.srdf", "--spheres",
             scratch() / "arm.urdf"});
    CwmJson({"put", "post", "--box", "0.2,0.2,0.2", "--at", "1,0,0"});
  }
  std::vector<std::string> Verdicts(const std::vector<std::string>& arguments) {
    std::vector<std::string> verdicts;
    const json answer = CwmJson(arguments);
    for (const json& row : answer.at("rows")) verdicts.push_back(row.at("verdict"));
    return verdicts;
  }
};

TEST_F(RobotQuery, ChecksStatesByNumbersByNameAndAsItStands) {
  EXPECT_THAT(Verdicts({"check", "--robot", "arm"}), ::testing::ElementsAre("VERDICT_COLLISION"));
  EXPECT_THAT(Verdicts({"check", "--robot", "arm", "--group", "both", "--joints", "1.5,0",
                        "--joints", "0,0", "--joints", "1.5,3", "--joints=-3.1,0", "--joints",
                        "aside", "--joints", "bent"}),
              ::testing::ElementsAre("VERDICT_FREE", "VERDICT_COLLISION", "VERDICT_COLLISION",
                                     "VERDICT_OUT_OF_LIMITS", "VERDICT_FREE", "VERDICT_COLLISION"));
  EXPECT_THAT(Verdicts({"check", "--robot", "arm", "--joints", "bent", "--scope", "world"}),
              ::testing::ElementsAre("VERDICT_FREE"));
  const json itself =
      CwmJson({"check", "--robot", "arm", "--joints", "bent", "--geometry", "spheres_as_given"});
  EXPECT_EQ(itself.at("rows").at(0).at("body_link"), "base");
  EXPECT_EQ(itself.at("rows").at(0).at("object_link"), "hand");
  EXPECT_EQ(itself.at("rows").at(0).at("trust"), "TRUST_DEGRADED");
}

TEST_F(RobotQuery, IsAnsweredAsIfTheWorldWereChanged) {
  const std::vector<std::string> check = {"check", "--robot", "arm"};
  const auto supposing = [&](const std::vector<std::string>& changes) {
    std::vector<std::string> arguments = check;
    for (const std::string& change : changes) {
      arguments.insert(arguments.end(), {"--what-if", change});
    }
    return Verdicts(arguments)[0];
  };
  EXPECT_EQ(supposing({"remove post"}), "VERDICT_FREE");
  EXPECT_EQ(supposing({"move post 2,0,0"}), "VERDICT_FREE");
  EXPECT_EQ(supposing({"move post 2,0,0", "move post 1,0,0"}), "VERDICT_COLLISION");
  EXPECT_EQ(supposing({"allow post,arm:hand"}), "VERDICT_FREE");
  EXPECT_EQ(supposing({"attach post arm:hand"}), "VERDICT_FREE");
  EXPECT_EQ(Verdicts(check)[0], "VERDICT_COLLISION") << "nothing was changed";
  const ProcessResult wrong = Cwm({"check", "--robot", "arm", "--what-if", "remove nobody"});
  EXPECT_EQ(wrong.exit_code, 3) << wrong.err;
}

TEST_F(RobotQuery, TellsDistancesLinkByLinkWithTheirGradients) {
  // The hand at (1, 0, 0) is below a box whose lower face is at y = 0.9.
  CwmJson({"move", "post", "--at", "1,1,0"});
  const std::vector<std::string> distance = {"distance", "--robot", "arm",    "--joints", "0,0",
                                             "--pairs",  "links",   "--only", "post"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), distance.begin(), distance.end());
    return more;
  };
  const json all = CwmJson(with({"--max-distance", "2", "--gradient"}));
  EXPECT_EQ(all.at("variables"), json({"shoulder", "elbow"}));
  const json& answers = all.at("rows").at(0).at("answers");
  ASSERT_EQ(answers.size(), 3u);
  EXPECT_EQ(answers.at(2).at("body_link"), "hand");
  EXPECT_NEAR(answers.at(2).at("distance_m"), 0.8, 1e-9);
  EXPECT_NEAR(answers.at(2).at("joint_gradient").at(0), -1, 1e-9);
  EXPECT_NEAR(answers.at(2).at("joint_gradient").at(1), -0.5, 1e-9);
  const json hand = CwmJson(with({"--max-distance", "2", "--only", "arm:hand"}));
  EXPECT_EQ(hand.at("rows").at(0).at("answers").size(), 3u);  // with its self pairs
  const ProcessResult table = Cwm(with({"--max-results", "1", "--gradient"}));
  for (const char* text : {"d/shoulder", "d/elbow", "-1.0000", "-0.5000"}) {
    EXPECT_THAT(table.out, HasSubstr(text));
  }
  EXPECT_THAT(Cwm(distance).err, HasSubstr("options.max_distance_m"));
  EXPECT_THAT(Cwm(with({"--only", "pots"})).err, HasSubstr("\"pots\", must be an object"));
  const ProcessResult wrong = Cwm({"distance", "--robot", "arm", "--pairs", "parts"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_THAT(wrong.err, HasSubstr("--pairs: \"parts\" must be links or objects"));
}

TEST_F(RobotQuery, LimitsThePointsOfAPair) {
  const auto points = [&](const std::vector<std::string>& more) {
    std::vector<std::string> contacts = {"contacts",  "--box",    "0.1,0.1,0.1", "--at",
                                         "1,0,0.149", "--ignore", "arm"};
    contacts.insert(contacts.end(), more.begin(), more.end());
    return CwmJson(contacts).at("rows").at(0).at("answers").size();
  };
  EXPECT_GE(points({}), 4u);
  EXPECT_EQ(points({"--max-contacts-per-pair", "2"}), 2u);
}

TEST_F(RobotQuery, ShowsLinksToPeople) {
  const ProcessResult table =
      Cwm({"check", "--robot", "arm", "--joints", "0,0", "--joints", "bent"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  for (const char* text : {"BODY LINK", "post", "itself", "hand", "base", "2 of 2 rows"}) {
    EXPECT_THAT(table.out, HasSubstr(text));
  }
  const ProcessResult near =
      Cwm({"distance", "--robot", "arm", "--joints", "aside", "--max-results", "2"});
  EXPECT_THAT(near.out, HasSubstr("itself"));
  EXPECT_THAT(near.out, HasSubstr("post"));
  EXPECT_THAT(Cwm({"contacts", "--robot", "arm"}).out, HasSubstr("hand"));
  const ProcessResult motion =
      Cwm({"motion", "--robot", "arm", "--joints", "aside", "--joints", "0,0"});
  for (const char* text : {"contact", "post", "hand", "FREE TO", "exact", "1 of 1 motion"}) {
    EXPECT_THAT(motion.out, HasSubstr(text));
  }
  EXPECT_EQ(motion.out.find("motions"), std::string::npos);
  EXPECT_THAT(Cwm({"motion", "--help"}).out, HasSubstr("Examples:\n  cwm motion"));
}

TEST_F(RobotQuery, NamesTheJointThatIsOutOfItsLimits) {
  const json checked = CwmJson({"check", "--robot", "arm", "--joints", "0,3.1", "--joints", "0,0"});
  EXPECT_EQ(checked.at("rows").at(0).at("variable"), "elbow");
  EXPECT_FALSE(checked.at("rows").at(1).contains("variable"));
  const json moved =
      CwmJson({"motion", "--robot", "arm", "--joints", "1.5,0", "--joints", "3.1,0"});
  EXPECT_EQ(moved.at("rows").at(0).at("variable"), "shoulder");
  for (const char* command : {"check", "motion"}) {
    const ProcessResult table =
        Cwm({command, "--robot", "arm", "--joints", "1.5,0", "--joints", "1.5,3.1"});
    EXPECT_THAT(table.out, HasSubstr("OUT OF LIMITS"));
    EXPECT_THAT(table.out, HasSubstr("elbow"));
  }
}

TEST_F(RobotQuery, SaysByItsExitCodeWhatItMet) {
  const auto exit_code = [&](std::vector<std::string> arguments, const std::string& input = "") {
    const ProcessResult finished = Cwm(std::move(arguments), input);
    return finished.exit_code;
  };
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--exit-code"}), 10);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints", "aside", "--exit-code"}), 0);
  EXPECT_EQ(exit_code({"motion", "--robot", "arm", "--joints", "aside", "--joints", "bent",
                       "--exit-code"}),
            10);
  EXPECT_EQ(exit_code({"motion", "--robot", "arm", "--joints", "1.5,0", "--joints", "2.5,0",
                       "--exit-code"}),
            0);
  // A state that is not known to be free must not be reported as free.
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints=-3.1,0", "--exit-code"}), 11);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints=-3.1,0"}), 0);
  EXPECT_EQ(
      exit_code({"check", "--robot", "arm", "--joints=-3.1,0", "--joints", "0,0", "--exit-code"}),
      10)
      << "a collision outweighs it";
  EXPECT_EQ(exit_code({"motion", "--robot", "arm", "--joints", "aside", "--joints", "3.1,0",
                       "--exit-code"}),
            11);
  std::string many;
  for (int i = 0; i < 2000; ++i) many += "[1.5, 0]\n";
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints", "-", "--time-budget", "1e-6",
                       "--exit-code"},
                      many),
            11);
  EXPECT_EQ(exit_code({"check", "--robot", "ghost"}), 3);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--group", "leg"}), 8);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints", "1,2,3"}), 8);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints", "nan,0"}), 8);
  EXPECT_EQ(exit_code({"check", "--robot", "arm", "--joints", "nowhere"}), 1);
  EXPECT_EQ(
      exit_code({"check", "--robot", "arm", "--geometry", "spheres_containing", "--exit-code"}), 11)
      << "their contact proves nothing";
  EXPECT_EQ(exit_code({"motion", "--robot", "arm", "--joints", "aside"}), 1);
  EXPECT_EQ(exit_code({"motion", "--robot", "arm", "--joints", "-"}, "[[0, 0], [1]]\n"), 8);
  const ProcessResult bad =
      Cwm({"check", "--robot", "arm", "--joints", "1.5,0", "--joints", "nan,0"});
  EXPECT_THAT(bad.err, HasSubstr("subject.robot.rows.data row 1: shoulder is nan"));
  EXPECT_THAT(Cwm({"check", "--robot", "arm", "--joints", "nowhere"}).err,
              HasSubstr("named state: aside, bent"));
}

TEST_F(RobotQuery, TakesMotionsFromLinesAndAnswersEachByALine) {
  const std::string lines =
      "{\"robot\": \"arm\", \"group\": \"both\", \"joints\": [[1.5, 0], [2.5, 0]]}\n"
      "{\"robot\": \"arm\", \"group\": \"both\", \"joints\": [[1.5, 0], [1, 0], [0, 0]]}\n"
      "{\"sphere\": 0.1, \"at\": [[0, 1, 0], [2, 1, 0], [2, 0, 0], [0, 0, 0]]}\n"
      "{\"object\": \"post\", \"at\": [[1, 0, 0.3], [1, 0, 5]]}\n";
  const ProcessResult answered = Cwm({"-o", "ndjson", "motion"}, lines);
  EXPECT_EQ(answered.exit_code, 0) << answered.err;
  std::vector<json> rows;
  std::istringstream out(answered.out);
  for (std::string line; std::getline(out, line);) rows.push_back(json::parse(line));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0].at("verdict"), "MOTION_VERDICT_FREE");
  EXPECT_EQ(rows[1].at("verdict"), "MOTION_VERDICT_CONTACT");
  EXPECT_EQ(rows[1].at("segment"), 1);
  EXPECT_EQ(rows[1].at("body_link"), "hand");
  EXPECT_EQ(rows[2].at("segment"), 2);
  // Starting from x = 2, the ball touches the box's face at x = 1.1 when its centre is at 1.2.
  EXPECT_LE(rows[2].at("lo").get<double>(), 0.4);
  EXPECT_GE(rows[2].at("hi").get<double>(), 0.4);
  EXPECT_EQ(rows[3].at("verdict"), "MOTION_VERDICT_FREE");
}

// More rows than one message can hold: they are sent as columns and printed as rows.
TEST_F(RobotQuery, ChecksThousandsOfStates) {
  std::string lines;
  for (int k = 0; k < 3'000; ++k) lines += k % 3 == 0 ? "[1.5, 3]\n" : "[1.5, 0]\n";
  const json answer = CwmJson({"check", "--robot", "arm", "--joints", "-"}, lines);
  ASSERT_EQ(answer.at("rows").size(), 3'000u);
  EXPECT_EQ(answer["rows"][2'997].at("object_link"), "hand");
  EXPECT_EQ(answer["rows"][2'998].at("verdict"), "VERDICT_FREE");
  EXPECT_EQ(answer["rows"][2'998].at("trust"), "TRUST_EXACT");
  const std::string path = "{\"joints\": [[1.5, 0], [2.5, 0]]}\n";
  std::string motions;
  for (int k = 0; k < 2'500; ++k) motions += path;
  const json moved = CwmJson({"motion", "--robot", "arm", "--joints", "-"}, motions);
  EXPECT_EQ(moved.at("rows").size(), 2'500u);
  EXPECT_EQ(moved.at("completed_count"), "2500");
  EXPECT_EQ(moved.at("body_links").size(), 3u);
}

TEST_F(RobotQuery, AnswersForThePandaOfMotionBenchMaker) {
  const auto panda = OutsideData("motion_bench_maker/panda");
  if (!panda) GTEST_SKIP() << "the Panda (motion_bench_maker) is not in CWM_DATA";
  CwmJson({"robot", "load", *panda + "/panda.urdf", "--srdf", *panda + "/panda.srdf", "--spheres",
           *panda + "/panda_spherized.urdf", "--package-dir", *panda});
  const json met = CwmJson({"check", "--robot", "panda", "--joints", "ready"});
  EXPECT_EQ(met.at("rows").at(0).at("object"), "arm") << "it stands where the Panda stands";
  CwmJson({"robot", "remove", "arm"});
  const json ready = CwmJson({"check", "--robot", "panda", "--joints", "ready"});
  EXPECT_EQ(ready.at("rows").at(0).at("verdict"), "VERDICT_FREE");
  EXPECT_EQ(ready.at("rows").at(0).at("trust"), "TRUST_EXACT");
  const json bent = CwmJson({"check", "--robot", "panda", "--group", "panda_arm", "--joints",
                             "0,-0.785,0,-3.0,0,-0.01,0.785"});
  EXPECT_EQ(bent.at("rows").at(0).at("object_link"), "panda_link7");
  const json motion =
      CwmJson({"motion", "--robot", "panda", "--joints", "ready", "--joints", "extended"});
  EXPECT_EQ(motion.at("completed_count"), "1");
}

}  // namespace
}  // namespace cwm::testing
