// Every command, as a user types it.
#include <algorithm>
#include <fstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

class CommandLine : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    ASSERT_EQ(Cwm({"put", "crate", "--box", "1,1,1", "--at", "0,0,0"}).exit_code, 0);
  }
};

TEST_F(CommandLine, KnownAnswersComeBackFromEveryEngineThatKnowsThePair) {
  // A unit box, and a sphere of 0.25 m radius at x = 0.2 m and x = 1 m.
  for (const char* engine : {"auto", "exact", "fcl", "bullet"}) {
    SCOPED_TRACE(engine);
    const json far = CwmJson({"distance", "--sphere", "0.25", "--at", "1,0,0", "--engine", engine});
    EXPECT_NEAR(far["rows"][0]["answers"][0].at("distance_m").get<double>(), 0.25, 1e-6);
    EXPECT_NEAR(far["rows"][0]["answers"][0].at("normal").at("x").get<double>(), -1, 1e-6);
  }
  const json deep = CwmJson({"distance", "--sphere", "0.25", "--at", "0.2,0,0"});
  EXPECT_NEAR(deep["rows"][0]["answers"][0].at("distance_m").get<double>(), -0.55, 1e-12);
  EXPECT_EQ(deep["rows"][0]["answers"][0].at("object"), "crate");
  EXPECT_EQ(deep["rows"][0]["answers"][0].at("trust"), "TRUST_EXACT");
}

TEST_F(CommandLine, CheckSaysFreeOrCollisionAndCanExitWithIt) {
  const json both =
      CwmJson({"check", "--sphere", "0.1"}, "{\"at\": [0, 0, 0]}\n{\"at\": [2, 0, 0]}\n");
  EXPECT_EQ(both["rows"][0].at("verdict"), "VERDICT_COLLISION");
  EXPECT_EQ(both["rows"][0].at("object"), "crate");
  EXPECT_EQ(both["rows"][1].at("verdict"), "VERDICT_FREE");
  EXPECT_EQ(Cwm({"check", "--sphere", "0.1", "--at", "0,0,0", "--exit-code"}).exit_code, 10);
  EXPECT_EQ(Cwm({"check", "--sphere", "0.1", "--at", "2,0,0", "--exit-code"}).exit_code, 0);
  // A collision means a distance strictly below the margin. The distance from the box's face, minus
  // the radius, is 1.4 m.
  EXPECT_EQ(Cwm({"check", "--sphere", "0.1", "--at", "2,0,0", "--margin", "1.41", "--exit-code"})
                .exit_code,
            10);
  EXPECT_EQ(Cwm({"check", "--sphere", "0.1", "--at", "2,0,0", "--margin", "1.39", "--exit-code"})
                .exit_code,
            0);
}

TEST_F(CommandLine, ContactsAndRaysMeetTheCrate) {
  const json contacts = CwmJson({"contacts", "--sphere", "0.25", "--at", "0.7,0,0"});
  EXPECT_NEAR(contacts["rows"][0]["answers"][0].at("distance_m").get<double>(), -0.05, 1e-12);
  const json ray = CwmJson({"ray", "--from", "3,0,0", "--direction", "-1,0,0"});
  EXPECT_TRUE(ray["rows"][0].at("hit").get<bool>());
  EXPECT_NEAR(ray["rows"][0].at("distance_m").get<double>(), 2.5, 1e-12);
  EXPECT_NEAR(ray["rows"][0].at("normal").at("x").get<double>(), 1, 1e-12);
  const json samples = CwmJson({"sample", "3,0,0", "-0.1,0,0", "9,0,0", "--max-distance", "5"});
  EXPECT_EQ(samples["rows"][0].at("state"), "SAMPLE_STATE_SMOOTH");
  EXPECT_NEAR(samples["rows"][0].at("distance_m").get<double>(), 2.5, 1e-12);
  EXPECT_NEAR(samples["rows"][0].at("gradient").at("x").get<double>(), 1, 1e-12);
  EXPECT_LT(samples["rows"][1].at("distance_m").get<double>(), 0);
  EXPECT_EQ(samples["rows"][2].at("state"), "SAMPLE_STATE_BEYOND");
  EXPECT_FALSE(samples["rows"][2].contains("distance_m"));
  const json miss = CwmJson({"ray", "--from", "3,0,2", "--direction", "-1,0,0"});
  EXPECT_FALSE(miss["rows"][0].at("hit").get<bool>());
  EXPECT_FALSE(miss["rows"][0].contains("distance_m")) << "what is unknown is absent";
}

TEST_F(CommandLine, PlacesCanBeNamedByAnObject) {
  const json above = CwmJson({"distance", "--sphere", "0.1", "--at", "crate+0,0,1"});
  EXPECT_NEAR(above["rows"][0]["answers"][0].at("distance_m").get<double>(), 0.4, 1e-12);
}

TEST_F(CommandLine, AMoveTouchesThePoseAlone) {
  const json before = CwmJson({"get", "crate"}).at("object");
  ASSERT_EQ(Cwm({"move", "crate", "--at", "0,0,5"}).exit_code, 0);
  const json after = CwmJson({"get", "crate"}).at("object");
  EXPECT_EQ(after.at("geometry_revision"), before.at("geometry_revision"));
  EXPECT_EQ(after.at("pose_revision"), "2");
  EXPECT_EQ(after.at("uid"), before.at("uid"));
  // The pinned revision still gives its old answer.
  const json then = CwmJson({"distance", "--sphere", "0.1", "--at", "0,0,1", "--at-revision", "1"});
  EXPECT_NEAR(then["rows"][0]["answers"][0].at("distance_m").get<double>(), 0.4, 1e-12);
  EXPECT_EQ(then.at("revision"), "1");
}

TEST_F(CommandLine, TablesAreForPeopleAndJsonIsForPrograms) {
  const ProcessResult table = Cwm({"objects"});
  EXPECT_EQ(table.exit_code, 0);
  EXPECT_NE(table.out.find("crate"), std::string::npos);
  EXPECT_EQ(table.out.find('\033'), std::string::npos) << "no colour where it is not a terminal";
  const ProcessResult lines = Cwm({"-o", "ndjson", "objects"});
  EXPECT_EQ(std::count(lines.out.begin(), lines.out.end(), '\n'), 1);
  EXPECT_EQ(json::parse(lines.out).at("name"), "crate");
}

TEST_F(CommandLine, StatusAndInfoNameVersionsAndEngines) {
  EXPECT_NE(Cwm({"status"}).out.find("default"), std::string::npos);
  const json info = CwmJson({"info"});
  EXPECT_EQ(info.at("engines").size(), 3U);
  EXPECT_EQ(info.at("limits").at("max_batch_rows"), "65536");
}

TEST_F(CommandLine, CallReachesAnyMethodThroughReflection) {
  const json worlds = CwmJson({"call", "cwm.v1.WorldService/ListWorlds", "{}"});
  EXPECT_EQ(worlds.at("worlds").at(0).at("name"), "default");
  const ProcessResult unknown = Cwm({"call", "cwm.v1.WorldService/Fly", "{}"});
  EXPECT_NE(unknown.exit_code, 0);
  EXPECT_NE(unknown.err.find("Fly"), std::string::npos) << unknown.err;
}

TEST_F(CommandLine, SegmentWritesTheSamePointsWithLabels) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "1"});
  const std::string labelled = scratch() / "labelled.pcd";
  ASSERT_EQ(Cwm({"segment", cloud, labelled}).exit_code, 0);
  std::ifstream file(labelled, std::ios::binary);
  std::string line, fields, points;
  while (std::getline(file, line) && line.rfind("DATA", 0) != 0) {
    if (line.rfind("FIELDS", 0) == 0) fields = line;
    if (line.rfind("POINTS", 0) == 0) points = line;
  }
  EXPECT_NE(fields.find("label"), std::string::npos) << fields;
  EXPECT_EQ(points, "POINTS 307200");
}

TEST_F(CommandLine, AMeshGoesInAndComesBack) {
  std::ofstream(scratch() / "tetrahedron.ply")
      << "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty "
         "float z\n"
         "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
  ASSERT_EQ(
      Cwm({"put", "wedge", "--mesh", scratch() / "tetrahedron.ply", "--at", "5,0,0"}).exit_code, 0);
  const json inside = CwmJson({"check", "--sphere", "0.01", "--at", "5.1,0.1,0.1"});
  EXPECT_EQ(inside["rows"][0].at("verdict"), "VERDICT_COLLISION") << "closed geometry contains";
  ASSERT_EQ(Cwm({"get", "wedge", "--mesh", scratch() / "back.ply"}).exit_code, 0);
  std::ifstream back(scratch() / "back.ply");
  std::string magic;
  std::getline(back, magic);
  EXPECT_EQ(magic, "ply");
}

TEST_F(CommandLine, AnObjectOfShapesAloneComesAsAMeshOfThem) {
  const auto first_bytes = [](const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes(512, '\0');
    file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return bytes;
  };
  ASSERT_EQ(Cwm({"move", "crate", "--at", "10,0,0"}).exit_code, 0);
  const std::string ply = scratch() / "crate.ply";
  ASSERT_EQ(Cwm({"get", "crate", "--mesh", ply}).exit_code, 0);
  EXPECT_NE(first_bytes(ply).find("element vertex 8\n"), std::string::npos);
  EXPECT_NE(first_bytes(ply).find("element face 12\n"), std::string::npos);
  // The written mesh can be put again and is at the crate's place, since it is in the world's
  // frame.
  ASSERT_EQ(Cwm({"put", "copy", "--mesh", ply, "--world", "other"}).exit_code, 0);
  const json ray =
      CwmJson({"ray", "--from", "10,0,2", "--direction", "0,0,-1", "--world", "other"})["rows"][0];
  EXPECT_NEAR(ray.at("distance_m").get<double>(), 1.5, 1e-12);
  const std::string glb = scratch() / "crate.GLB";
  ASSERT_EQ(Cwm({"get", "crate", "--mesh", glb}).exit_code, 0);
  EXPECT_EQ(first_bytes(glb).substr(0, 4), "glTF");
  EXPECT_NE(first_bytes(glb).find(R"("min":[9.5,-0.5,-0.5],"max":[10.5,0.5,0.5])"),
            std::string::npos);
  // The mesh is that of the requested revision, with the crate's pose at that time.
  const std::string before = scratch() / "before.glb";
  ASSERT_EQ(Cwm({"get", "crate", "--mesh", before, "--at-revision", "1"}).exit_code, 0);
  EXPECT_NE(first_bytes(before).find(R"("max":[0.5,0.5,0.5])"), std::string::npos);
  const ProcessResult other = Cwm({"get", "crate", "--mesh", scratch() / "crate.stl"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.err.find("must end in .ply or .glb"), std::string::npos) << other.err;
  EXPECT_FALSE(std::ifstream(scratch() / "crate.stl").good());
}

TEST_F(CommandLine, WhatHasNoEndComesAsNoMesh) {
  ASSERT_EQ(
      Cwm({"call", "cwm.v1.WorldService/ApplyChanges",
           R"({"changes": [{"put": {"object": {"name": "ground", "shapes": [{"half_space": {}}]}}}]})"})
          .exit_code,
      0);
  const std::string ply = scratch() / "ground.ply";
  const ProcessResult refused = Cwm({"get", "ground", "--mesh", ply});
  EXPECT_EQ(refused.exit_code, 4);
  EXPECT_NE(refused.err.find("half-space"), std::string::npos) << refused.err;
  EXPECT_FALSE(std::ifstream(ply).good());
}

TEST_F(CommandLine, ExpectedRevisionAndRequestIdsGuardWriters) {
  const std::string put =
      R"({"expected_revision": "1", "request_id": "r1", "changes": [{"put": {"object":
      {"name": "x", "shapes": [{"sphere": {"radius_m": 0.1}}]}}}]})";
  EXPECT_EQ(CwmJson({"call", "cwm.v1.WorldService/ApplyChanges", put}).at("revision"), "2");
  EXPECT_EQ(CwmJson({"call", "cwm.v1.WorldService/ApplyChanges", put}).at("revision"), "2")
      << "a retry gets the first reply";
  std::string other = put;
  other.replace(other.find("0.1"), 3, "0.2");
  EXPECT_EQ(Cwm({"call", "cwm.v1.WorldService/ApplyChanges", other}).exit_code, 4)
      << "other content under the same id";
  other.replace(other.find("r1"), 2, "r2");
  const ProcessResult stale = Cwm({"call", "cwm.v1.WorldService/ApplyChanges", other});
  EXPECT_EQ(stale.exit_code, 4);
  EXPECT_NE(stale.err.find("REVISION_MISMATCH"), std::string::npos) << stale.err;
}

}  // namespace
}  // namespace cwm::testing
