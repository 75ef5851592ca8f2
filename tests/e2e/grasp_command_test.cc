// cwm-grasp with a running server: it finds grasps for objects, or says why there are none.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class GraspCommand : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    // A table top with its surface at z = 0.
    CwmJson({"put", "table", "--box", "2,2,0.04", "--at", "0,0,-0.02"});
  }

  ProcessResult Grasp(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {Program("cwm-grasp"), "--addr", address()});
    return RunProgram(arguments);
  }

  json Of(const std::string& name, std::vector<std::string> options = {}) const {
    options.insert(options.end(), {name, "-o", "json"});
    const ProcessResult finished = Grasp(options);
    EXPECT_EQ(finished.exit_code, 0) << finished.err;
    return finished.exit_code == 0 ? json::parse(finished.out).at("objects").at(0) : json();
  }
};

TEST_F(GraspCommand, TakesEveryKindOfShapeByItsWidth) {
  struct GraspCase {
    std::string name, option, size, at;
    double min_m, max_m;  // the range of its grasps' widths
  };
  const std::vector<GraspCase> cases = {
      {"box", "--box", "0.05,0.2,0.1", "0,0,0.05", 0.05, 0.05},
      {"can", "--cylinder", "0.03,0.12", "0.5,0,0.06", 0.06, 0.06},
      {"ball", "--sphere", "0.03", "0,0.5,0.03", 0.05, 0.06},
      {"cup", "--cone", "0.02,0.03,0.1", "0.5,0.5,0.05", 0.04, 0.06}};
  for (const GraspCase& object : cases) {
    CwmJson({"put", object.name, object.option, object.size, "--at", object.at});
  }
  for (const GraspCase& object : cases) {
    const json found = Of(object.name);
    ASSERT_FALSE(found.at("grasps").empty()) << object.name << ": " << found.at("why");
    double last = 1;
    for (const json& grasp : found["grasps"]) {
      const double width_m = grasp.at("width_m");
      EXPECT_GE(width_m, object.min_m - 1e-6) << object.name;
      EXPECT_LE(width_m, object.max_m + 1e-6) << object.name;
      EXPECT_GE(grasp.at("clearance_m").get<double>(), 0.002);
      EXPECT_LE(grasp.at("score").get<double>(), last) << "the best come first";
      last = grasp.at("score");
      for (const json& contact : grasp.at("contacts")) {
        EXPECT_LE(contact.at("angle_rad").get<double>(), std::atan(0.4));
      }
    }
  }
}

TEST_F(GraspCommand, TakesAMugByItsHandle) {
  // The body is 110 mm wide, so only the handle fits, and the body is an obstacle.
  const std::string mug =
      R"({"changes": [{"put": {"object": {"name": "mug", "x_world_object": {"qw": 1, "tz_m": 0.06},
          "shapes": [{"cylinder": {"radius_m": 0.055, "length_m": 0.12}},
                     {"box": {"size_x_m": 0.012, "size_y_m": 0.015, "size_z_m": 0.08},
                      "x_object_shape": {"tx_m": 0.09, "qw": 1}}]}}}]})";
  CwmJson({"call", "ApplyChanges", mug});
  const json found = Of("mug");
  ASSERT_FALSE(found.at("grasps").empty()) << found.at("why");
  for (const json& grasp : found["grasps"]) {
    for (const json& contact : grasp.at("contacts")) EXPECT_EQ(contact.at("part"), 1);
    EXPECT_GT(grasp.at("x_world_grasp").at("tx_m").get<double>(), 0.08);
  }
}

TEST_F(GraspCommand, SaysByHowMuchAThingIsTooWide) {
  CwmJson({"put", "crate", "--box", "0.09,0.3,0.2", "--at", "0,0,0.1"});
  const json found = Of("crate");
  EXPECT_TRUE(found.at("grasps").empty());
  EXPECT_THAT(found.at("why").get<std::string>(), HasSubstr("too wide by 14.0 mm"));
  EXPECT_FALSE(Of("crate", {"--opening", "0.1"}).at("grasps").empty());
}

TEST_F(GraspCommand, NamesWhatIsInTheWay) {
  CwmJson({"put", "can", "--cylinder", "0.03,0.1", "--at", "0,0,0.05"});
  EXPECT_FALSE(Of("can").at("grasps").empty());
  // Walls all around, at the distance of a finger's thickness.
  CwmJson({"put", "walls_x", "--box", "0.01,0.4,0.1", "--at", "0.045,0,0.05"});
  CwmJson({"put", "walls_y", "--box", "0.4,0.01,0.1", "--at", "0,0.045,0.05"});
  CwmJson({"put", "walls_u", "--box", "0.01,0.4,0.1", "--at", "-0.045,0,0.05"});
  CwmJson({"put", "walls_v", "--box", "0.4,0.01,0.1", "--at", "0,-0.045,0.05"});
  const json found = Of("can");
  EXPECT_TRUE(found.at("grasps").empty());
  EXPECT_THAT(found.at("why").get<std::string>(), HasSubstr("no free approach"));
  int walls = 0, all = 0;
  for (const auto& [name, count] : found.at("blocked_by").items()) {
    all += count.get<int>();
    if (name.rfind("walls_", 0) == 0) walls += count.get<int>();
  }
  EXPECT_EQ(all, found.at("tried_count"));
  EXPECT_GT(walls, all / 2);
}

TEST_F(GraspCommand, SaysHowToSeeTheGrasps) {
  CwmJson({"put", "ball", "--sphere", "0.03", "--at", "0,0,0.03"});
  EXPECT_THAT(Grasp({}).out, HasSubstr("to see them: add --json FILE"));
  const std::string path = scratch() / "grasps.json";
  EXPECT_THAT(Grasp({"--json", path}).out, HasSubstr("to see them: drop " + path));
  const json written = json::parse(std::ifstream(path));
  EXPECT_EQ(written.at("objects").size(), 2U);
  EXPECT_EQ(json::parse(Grasp({"-o", "json"}).out), written) << "a program reads all of it";
  const ProcessResult nowhere = Grasp({"--json", scratch() / "none/grasps.json"});
  EXPECT_NE(nowhere.exit_code, 0);
  EXPECT_THAT(nowhere.out, Not(HasSubstr("drop")));
}

// Each grasp casts 30 rays, and one query may have 65 536.
TEST_F(GraspCommand, TakesMoreThanOneQuestionHolds) {
  json changes = json::array();
  for (int i = 0; i < 24; ++i) {  // in the air, where every side can be reached
    const json pose = {{"tx_m", 0.6 * (i % 8)}, {"ty_m", 0.6 * (i % 3)}, {"tz_m", 1}, {"qw", 1}};
    const json box = {{"size_x_m", 0.05}, {"size_y_m", 0.2}, {"size_z_m", 0.1}};
    changes.push_back({{"put",
                        {{"object",
                          {{"name", "box_" + std::to_string(i)},
                           {"x_world_object", pose},
                           {"shapes", json::array({{{"box", box}}})}}}}}});
  }
  CwmJson({"call", "ApplyChanges", json{{"changes", changes}}.dump()});
  const ProcessResult finished = Grasp({"--top", "10000", "-o", "json"});
  ASSERT_EQ(finished.exit_code, 0) << finished.err;
  const json plan = json::parse(finished.out);
  std::size_t grasps = 0;
  for (const json& object : plan.at("objects")) grasps += object.at("grasps").size();
  EXPECT_EQ(plan["objects"].size(), 25U) << "the table too";
  EXPECT_GT(30 * grasps, 65'536U) << "as many as this is about";
}

TEST_F(GraspCommand, BadInputIsNamed) {
  CwmJson({"put", "ball", "--sphere", "0.03", "--at", "0,0,0.03"});
  const ProcessResult mistyped = Grasp({"bal"});
  EXPECT_EQ(mistyped.exit_code, 3);
  EXPECT_THAT(mistyped.err, HasSubstr("did you mean \"ball\"?"));
  EXPECT_THAT(mistyped.err, StartsWith("cwm-grasp: not found")) << "whose error it is";
  const ProcessResult narrow = Grasp({"--opening", "0"});
  EXPECT_EQ(narrow.exit_code, 1);
  EXPECT_THAT(narrow.err, HasSubstr("--opening: 0 m must be"));
  EXPECT_EQ(Grasp({"--palm", "1,2"}).exit_code, 1);
  EXPECT_EQ(Grasp({"-w", "nowhere"}).exit_code, 3);
  EXPECT_EQ(RunProgram({Program("cwm-grasp"), "--addr", "unix:" + scratch() / "none"}).exit_code,
            2);
}

}  // namespace
}  // namespace cwm::testing
