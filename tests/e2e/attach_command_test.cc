// `cwm attach`, `cwm detach` and queries about attached objects, as a user types them.
#include <gmock/gmock.h>

#include <fstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

// An arm that turns about z, with a ball of 0.1 m radius at its base and one at x = 0.5, its hand.
constexpr char kUrdf[] = R"(<robot name="arm">
<link name="base"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="hand">
<collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="turn" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3"/></joint></robot>
)";

class AttachCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    std::ofstream(scratch() / "arm.urdf") << kUrdf;
    CwmJson({"robot", "load", scratch() / "arm.urdf"});
    CwmJson({"put", "box", "--box", "0.1,0.1,0.1", "--at", "0.7,0,0"});
    CwmJson({"put", "post", "--box", "0.1,0.1,0.1", "--at", "0,0.75,0"});
  }
  // The verdict for the arm with its joint at `turn`.
  json CheckedRow(const std::string& turn, std::vector<std::string> more = {}) {
    std::vector<std::string> line = {"check", "--robot", "arm", "--joints", turn};
    line.insert(line.end(), more.begin(), more.end());
    return CwmJson(line).at("rows").at(0);
  }
};

TEST_F(AttachCommand, AttachesAsksAndDetaches) {
  EXPECT_EQ(CheckedRow("1.5708").at("verdict"), "VERDICT_FREE");
  EXPECT_THAT(Cwm({"attach", "box", "--robot", "arm", "--link", "hand"}).out,
              HasSubstr("attached box to arm:hand, revision 4"));
  const json met = CheckedRow("1.5708");
  EXPECT_EQ(met.at("verdict"), "VERDICT_COLLISION");
  EXPECT_EQ(met.at("object"), "post");
  EXPECT_EQ(met.at("body_object"), "box");
  EXPECT_THAT(Cwm({"check", "--robot", "arm", "--joints", "1.5708"}).out,
              HasSubstr("hand with box"));
  EXPECT_EQ(CheckedRow("1.5708", {"--ignore", "box"}).at("verdict"), "VERDICT_FREE");
  EXPECT_THAT(Cwm({"objects"}).out, HasSubstr("arm:hand"));
  EXPECT_THAT(Cwm({"get", "box"}).out, HasSubstr("arm:hand"));
  EXPECT_THAT(Cwm({"watch", "--once"}).out, HasSubstr("attached to arm:hand"));
  const json motion = CwmJson({"motion", "--robot", "arm", "--joints", "0", "--joints", "1.5708"});
  EXPECT_EQ(motion.at("rows").at(0).at("verdict"), "MOTION_VERDICT_CONTACT");
  EXPECT_EQ(motion.at("rows").at(0).at("body_object"), "box");
  EXPECT_THAT(Cwm({"detach", "box"}).out, HasSubstr("detached box"));
  EXPECT_EQ(CheckedRow("1.5708").at("verdict"), "VERDICT_FREE");
}

TEST_F(AttachCommand, TakesAPoseAndLinksThatMayTouch) {
  // At this pose the box encloses the base of the robot.
  CwmJson({"attach", "box", "--robot", "arm", "--link", "hand", "--pose", "0,0,0"});
  EXPECT_EQ(CheckedRow("0").at("object_link"), "base");
  CwmJson({"attach", "box", "--robot", "arm", "--link", "hand", "--pose", "0,0,0", "--touch-links",
           "base,hand"});
  EXPECT_EQ(CheckedRow("0").at("verdict"), "VERDICT_FREE");
  EXPECT_THAT(Cwm({"get", "box"}).out, HasSubstr("base, hand"));
}

TEST_F(AttachCommand, SupportsMayBeReachedInto) {
  CwmJson({"put", "table", "--box", "1,1,0.1", "--at", "2,0,-0.05"});
  CwmJson({"put", "cup", "--box", "0.1,0.1,0.1", "--at", "2,0,0.047", "--supported-by", "table"});
  const auto verdict = [&](std::vector<std::string> more) {
    std::vector<std::string> line = {"check", "--object", "cup"};
    line.insert(line.end(), more.begin(), more.end());
    return CwmJson(line).at("rows").at(0).at("verdict");
  };
  EXPECT_EQ(verdict({}), "VERDICT_FREE");
  EXPECT_EQ(verdict({"--support-tolerance", "0.002"}), "VERDICT_COLLISION");
  EXPECT_EQ(Cwm({"check", "--object", "cup", "--support-tolerance", "1"}).exit_code, 8);
}

TEST_F(AttachCommand, RobotsAreObstacles) {
  const json met = CwmJson({"check", "--sphere", "0.05", "--at", "0.5,0,0"}).at("rows").at(0);
  EXPECT_EQ(met.at("object"), "arm");
  EXPECT_EQ(met.at("object_link"), "hand");
  EXPECT_THAT(Cwm({"ray", "--from", "0.5,0,2", "--direction", "0,0,-1"}).out,
              HasSubstr("arm:hand"));
  EXPECT_EQ(CwmJson({"check", "--sphere", "0.05", "--at", "0.5,0,0", "--ignore", "arm"})
                .at("rows")
                .at(0)
                .at("verdict"),
            "VERDICT_FREE");
}

TEST_F(AttachCommand, SaysWhatIsWrong) {
  const auto failure = [&](std::vector<std::string> line, int exit_code, const std::string& text) {
    const ProcessResult finished = Cwm(std::move(line));
    EXPECT_EQ(finished.exit_code, exit_code) << finished.err;
    EXPECT_THAT(finished.err, HasSubstr(text));
  };
  failure({"attach", "box", "--robot", "arm"}, 1, "--link");
  failure({"attach", "box", "--robot", "arm", "--link", "tail"}, 8, "attach.link");
  failure({"attach", "box", "--robot", "arm", "--link", "hnd"}, 8, "did you mean hand?");
  failure({"attach", "box", "--robot", "arm", "--link", "hand", "--touch-links", "bse"}, 8,
          "did you mean base?");
  failure({"attach", "box", "--robot", "nobody", "--link", "hand"}, 3, "nobody");
  failure({"attach", "ghost", "--robot", "arm", "--link", "hand"}, 3, "ghost");
  failure({"detach", "ghost"}, 3, "ghost");
}

}  // namespace
}  // namespace cwm::testing
