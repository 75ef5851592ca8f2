// The output of every command in each form, and its exit codes: tables for people, JSON with the
// API's answer, NDJSON with one line per element.
#include <fstream>
#include <functional>
#include <sstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

constexpr int kUsage = 1, kNotFound = 3;  // exit codes: see `cwm --help`
constexpr int kConflict = 4;
constexpr int kDeadline = 5;
constexpr int kBadInput = 8;
constexpr int kAnythingElse = 70;

// A MoveIt planning scene: a board and a can on it; the can is one primitive of an object that has
// a pose of its own.
constexpr char kScene[] = R"(name: kitchen
world:
  collision_objects:
    - id: board
      primitives:
        - {type: box, dimensions: [0.8, 0.6, 0.02]}
      primitive_poses:
        - {position: [0.5, 0, 0.4], orientation: [0, 0, 0, 1]}
    - id: can
      pose: {position: [0.5, 0, 0.45], orientation: [0, 0, 0, 1]}
      primitives:
        - {type: cylinder, dimensions: [0.1, 0.033]}
      primitive_poses:
        - {position: [0, 0, 0.01], orientation: [0, 0, 0, 1]}
)";

class OutputForms : public ServerTest {
 protected:
  // Puts a unit cube at the origin.
  void SetUp() override {
    ServerTest::SetUp();
    ASSERT_EQ(Cwm({"put", "crate", "--box", "1,1,1", "--at", "0,0,0"}).exit_code, 0);
  }

  std::string Table(const std::vector<std::string>& arguments) const {
    const ProcessResult run = Cwm(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(run.err, "") << "progress and logs are for terminals";
    return run.out;
  }
  std::vector<json> Lines(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"-o", "ndjson"});
    const ProcessResult run = Cwm(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::vector<json> lines;
    std::istringstream text(run.out);
    for (std::string line; std::getline(text, line);) lines.push_back(json::parse(line));
    return lines;
  }
  std::string Write(const std::string& name, const std::string& content) const {
    std::ofstream(scratch() / name, std::ios::binary) << content;
    return scratch() / name;
  }
  void ExpectExit(const std::vector<std::string>& arguments, int exit_code,
                  const std::string& said) const {
    const ProcessResult run = Cwm(arguments);
    EXPECT_EQ(run.exit_code, exit_code) << run.err;
    EXPECT_EQ(run.out, "") << "errors belong to stderr";
    EXPECT_NE(run.err.find(said), std::string::npos) << "'" << said << "' not in: " << run.err;
  }
};

void ExpectWords(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << "'" << word << "' not in:\n" << text;
  }
}

TEST_F(OutputForms, StatusNamesTheServerAndItsWorlds) {
  ExpectWords(Table({"status"}), {"SERVING", address(), "WORLD", "default"});
  const json whole = CwmJson({"status"});
  EXPECT_EQ(whole.at("health"), "SERVING");
  EXPECT_EQ(whole.at("worlds").at(0).at("name"), "default");
  EXPECT_EQ(whole.at("worlds").at(0).at("object_count"), "1");
  const std::vector<json> lines = Lines({"status"});
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].at("worlds"), whole.at("worlds"));
}

TEST_F(OutputForms, ObjectsAndGetDescribeTheCrate) {
  ExpectWords(Table({"objects"}),
              {"NAME", "KIND", "crate", "user", "box 1.000 x 1.000 x 1.000 m", "revision 1\n"});
  ExpectWords(Table({"get", "crate"}), {"crate", "owner", "user", "created 1", "revision 1\n"});
  const json object = CwmJson({"objects"}).at("objects").at(0);
  EXPECT_EQ(object.at("shapes").at(0).at("box"),
            json({{"size_x_m", 1.0}, {"size_y_m", 1.0}, {"size_z_m", 1.0}}));
  EXPECT_EQ(CwmJson({"get", "crate"}).at("object"), object);
  EXPECT_EQ(Lines({"objects"}), std::vector<json>{object});
  EXPECT_EQ(Lines({"get", "crate"}).at(0).at("object"), object);
  ExpectExit({"get", "crat"}, kNotFound, "crat");
  ExpectExit({"objects", "--world", "nowhere"}, kNotFound, "nowhere");
}

TEST_F(OutputForms, PutMoveAndRemoveTellTheRevisionThatTheyMade) {
  EXPECT_EQ(Table({"put", "a", "--sphere", "0.1", "--at", "3,0,0"}), "put a, revision 2\n");
  EXPECT_EQ(CwmJson({"put", "b", "--sphere", "0.1", "--at", "4,0,0"}).at("revision"), "3");
  EXPECT_EQ(Lines({"put", "c", "--sphere", "0.1", "--at", "5,0,0"}).at(0).at("revision"), "4");
  EXPECT_EQ(Table({"move", "a", "--at", "3,1,0"}), "moved a, revision 5\n");
  EXPECT_EQ(CwmJson({"move", "b", "--by", "0,1,0"}).at("revision"), "6");
  EXPECT_EQ(Lines({"move", "c", "--at", "5,1,0"}).at(0).at("revision"), "7");
  EXPECT_EQ(CwmJson({"get", "b"}).at("object").at("x_world_object").at("ty_m"), 1);
  EXPECT_EQ(Table({"remove", "a"}), "removed a, revision 8\n");
  EXPECT_EQ(CwmJson({"remove", "b"}).at("revision"), "9");
  EXPECT_EQ(Lines({"remove", "c"}).at(0).at("revision"), "10");
  ExpectExit({"put", "a", "--sphere", "-0.1"}, kBadInput, "radius_m");
  ExpectExit({"move", "a", "--at", "0,0,0"}, kNotFound, "object 'a' does not exist");
  ExpectExit({"remove", "crate", "a"}, kNotFound, "object 'a' does not exist");
  ExpectExit({"remove", "crate", "--expected-revision", "9"}, kConflict, "REVISION_MISMATCH");
  EXPECT_EQ(RevisionOf("default"), 10) << "all or nothing";
}

TEST_F(OutputForms, ImportPutsTheObjectsOfASceneInOneRevision) {
  const std::string scene = Write("scene.yaml", kScene);
  EXPECT_EQ(Table({"import", scene}), "imported 2 objects, revision 2\n");
  EXPECT_EQ(CwmJson({"import", scene, "--world", "b"}).at("revision"), "1");
  EXPECT_EQ(Lines({"import", scene, "--world", "c"}).at(0).at("revision"), "1");
  const json board = CwmJson({"get", "board"}).at("object");
  EXPECT_EQ(board.at("shapes").at(0).at("box"),
            json({{"size_x_m", 0.8}, {"size_y_m", 0.6}, {"size_z_m", 0.02}}));
  EXPECT_EQ(board.at("x_world_object").at("tz_m"), 0.4);
  EXPECT_EQ(board.at("owner"), "OWNER_USER");
  const json can = CwmJson({"get", "can"}).at("object").at("shapes").at(0);
  EXPECT_EQ(can.at("cylinder"), json({{"radius_m", 0.033}, {"length_m", 0.1}}));
  EXPECT_EQ(can.at("x_object_shape").at("tz_m"), 0.01);
  // A ray from 1 m above the can's top: 0.45 + 0.01 + 0.05.
  const json ray =
      CwmJson({"ray", "--from", "0.5,0,1.51", "--direction", "0,0,-1", "--world", "b"});
  EXPECT_EQ(ray.at("rows").at(0).at("object"), "can");
  EXPECT_NEAR(ray["rows"][0].at("distance_m").get<double>(), 1, 1e-12);

  std::string negative = kScene;
  negative.replace(negative.find("0.033"), 5, "-0.03");
  ExpectExit({"import", Write("bad.yaml", negative)}, kBadInput,
             "bad.yaml: world.collision_objects[1].primitives[0].dimensions[1] is -0.03, must be "
             "positive");
  ExpectExit({"import", Write("cut.yaml", "world: [")}, kBadInput, "cut.yaml");
}

TEST_F(OutputForms, DistanceAndContactsGiveTheNumbersInEveryForm) {
  // A ball of 0.25 m radius whose centre is 1 m (0.7 m) from the cube's: 0.25 m apart (0.05 m
  // deep).
  const std::vector<std::string> apart = {"distance", "--sphere", "0.25", "--at", "1,0,0"};
  ExpectWords(Table(apart), {"DISTANCE mm", "250.000", "crate", "0.500 0.000 0.000",
                             "-1.000 0.000 0.000", "exact", "revision 1, 1 of 1 row\n"});
  EXPECT_NEAR(CwmJson(apart)["rows"][0]["answers"][0].at("distance_m").get<double>(), 0.25, 1e-12);
  EXPECT_EQ(Lines(apart), CwmJson(apart).at("rows").get<std::vector<json>>());
  const std::vector<std::string> deep = {"contacts", "--sphere", "0.25", "--at", "0.7,0,0"};
  ExpectWords(Table(deep), {"-50.000", "crate", "exact"});
  EXPECT_NEAR(CwmJson(deep)["rows"][0]["answers"][0].at("distance_m").get<double>(), -0.05, 1e-12);
  EXPECT_EQ(Lines(deep), CwmJson(deep).at("rows").get<std::vector<json>>());
  ExpectWords(Table({"contacts", "--sphere", "0.25", "--at", "1,0,0"}), {"none"});
  for (const char* command : {"distance", "contacts"}) {
    ExpectExit({command, "--sphere", "nan", "--at", "1,0,0"}, kBadInput, "radius_m");
    ExpectExit({command, "--sphere", "1", "--at", "1,0,0", "--world", "x"}, kNotFound, "\"x\"");
    ExpectExit({command, "--sphere", "1", "--at", "1,0,0", "--at-revision", "7"}, kConflict, "7");
  }
}

TEST_F(OutputForms, CheckGivesAVerdictARowInEveryForm) {
  const std::vector<std::string> both = {"check", "--sphere", "0.1",  "--at",
                                         "0,0,0", "--at",     "2,0,0"};
  ExpectWords(Table(both), {"VERDICT", "collision", "crate", "free", "revision 1, 2 of 2 rows\n"});
  const json rows = CwmJson(both).at("rows");
  EXPECT_EQ(rows.at(0).at("verdict"), "VERDICT_COLLISION");
  EXPECT_EQ(rows.at(1).at("verdict"), "VERDICT_FREE");
  EXPECT_EQ(Lines(both), rows.get<std::vector<json>>());
  ExpectExit({"check", "--sphere", "0.1", "--at", "0,0,0,1,1,0,0"}, kBadInput, "must");
}

TEST_F(OutputForms, RayGivesHitsAndMissesInEveryForm) {
  const std::vector<std::string> hit = {"ray", "--from", "3,0,0", "--to", "0,0,0"};
  ExpectWords(Table(hit), {"2500.000", "crate", "0.500 0.000 0.000", "1.000 0.000 0.000"});
  EXPECT_NEAR(CwmJson(hit)["rows"][0].at("distance_m").get<double>(), 2.5, 1e-12);
  EXPECT_EQ(Lines(hit), CwmJson(hit).at("rows").get<std::vector<json>>());
  ExpectWords(Table({"ray", "--from", "3,0,2", "--to", "0,0,2"}), {"none"});
  ExpectExit({"ray", "--from", "3,0,0", "--direction", "0,0,0"}, kBadInput, "direction");
}

TEST_F(OutputForms, SampleGivesDistancesAndGradientsInEveryForm) {
  const std::vector<std::string> beside = {"sample", "3,0,0"};
  ExpectWords(Table(beside), {"2500.000", "crate", "1.000 0.000 0.000", "1 of 1 row\n"});
  EXPECT_NEAR(CwmJson(beside)["rows"][0].at("distance_m").get<double>(), 2.5, 1e-12);
  EXPECT_EQ(Lines(beside), CwmJson(beside).at("rows").get<std::vector<json>>());
  ExpectWords(Table({"sample", "0,0,0"}), {"-500.000", "kink"});
  ExpectWords(Table({"sample", "3,0,0", "--max-distance", "1"}), {"none"});
  ExpectExit({"sample", "3,0,0", "--engine", "fcl"}, kAnythingElse, "FCL");
}

TEST_F(OutputForms, WatchTellsTheWorldInEveryForm) {
  ExpectWords(Table({"watch", "--once"}),
              {"1  is      crate  user  box 1.000 x 1.000 x 1.000 m  at 0.000 0.000 0.000 m",
               "that is the world, uid " + UidOf("default")});
  for (const char* form : {"json", "ndjson"}) {
    const ProcessResult run = Cwm({"-o", form, "watch", "--once"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::istringstream lines(run.out);
    std::string first;
    std::getline(lines, first);
    EXPECT_EQ(json::parse(first).at("initial_state").at("objects").at(0).at("name"), "crate");
  }
  ExpectExit({"watch", "--once", "--world", "nowhere"}, kNotFound, "nowhere");
  const std::string uid = UidOf("default");
  ExpectExit({"watch", "--from", "99", "--world-uid", uid}, kConflict, "99");
  ExpectExit({"watch", "--from", "1", "--world-uid", "another"}, kConflict, uid);
  ExpectExit({"watch", "--from", "1"}, kUsage, "--world-uid");
  EXPECT_EQ(Cwm({"watch", "--from", "0", "--count", "1"}).exit_code, 0);
  const ProcessResult idle = Cwm({"watch", "--from", "1", "--world-uid", uid, "--deadline", "0.5"});
  EXPECT_EQ(idle.exit_code, kDeadline) << idle.err;
}

TEST_F(OutputForms, AReaderThatHasHadEnoughEndsItQuietlyAndAFullDiskDoesNot) {
  const auto shell = [&](const std::string& command) {
    const std::string line = "set -o pipefail; CWM_ADDR=" + address() + "; export CWM_ADDR; ";
    return RunProgram({"timeout", "20", "bash", "-c", line + Program("cwm") + command});
  };
  // The world does not change, so no further write could fail.
  const ProcessResult watch = shell(" -o ndjson watch | head -1");
  EXPECT_EQ(watch.exit_code, 0) << watch.err;
  EXPECT_EQ(json::parse(watch.out).at("initial_state").at("objects").at(0).at("name"), "crate");
  const ProcessResult objects = shell(" objects | true");
  EXPECT_EQ(objects.exit_code, 0) << objects.err;
  const ProcessResult full = shell(" objects >/dev/full");
  EXPECT_EQ(full.exit_code, 70);
  EXPECT_NE(full.err.find("stdout cannot be written"), std::string::npos) << full.err;
}

TEST_F(OutputForms, CallPrintsTheReplyInEveryForm) {
  const std::vector<std::string> call = {"call", "GetObject", R"({"name": "crate"})"};
  const json reply = CwmJson(call);
  EXPECT_EQ(reply.at("object"), CwmJson({"get", "crate"}).at("object"));
  EXPECT_EQ(json::parse(Table(call)), reply);
  EXPECT_EQ(Lines(call), std::vector<json>{reply});
  ExpectExit({"call", "GetObject", R"({"name": "unicorn"})"}, kNotFound, "unicorn");
  ExpectExit({"call", "GetObject", R"({"nome": "crate"})"}, kBadInput, "nome");
  ExpectExit({"call", "GetObject", "crate"}, kBadInput, "JSON");
  // More points than the server accepts: refused after the header, before any data.
  ExpectExit({"call", "IngestCloud",
              R"({"header": {"point_count": 20000001, "total_bytes": 240000012, "layout":
                 {"point_step": 12, "fields": [{"name": "x", "type": "FIELD_TYPE_F32"},
                 {"name": "y", "offset": 4, "type": "FIELD_TYPE_F32"},
                 {"name": "z", "offset": 8, "type": "FIELD_TYPE_F32"}]}}})"},
             kBadInput, "20000001");
}

}  // namespace
}  // namespace cwm::testing
