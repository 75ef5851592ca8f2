// Exported worlds, read by independent programs.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/collision/robot/robot_text.h"
#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

constexpr char kValidator[] = "clients/web/node_modules/gltf-validator/package.json";

class ExportCommand : public ServerTest {
 protected:
  std::string File(const std::string& name) const { return scratch() / name; }

  // Objects of every look except those of perception, and a robot.
  void PutObjects() const {
    CwmJson({"put", "can", "--cylinder", "0.03,0.1", "--at", "0,0,1"});
    CwmJson({"put", "hat", "--cone", "0.1,0,0.2", "--at", "1,0,1"});
    CwmJson({"put", "dark", "--box", "1,1,1", "--at", "3,0,1", "--unseen"});
    CwmJson(
        {"call", "ApplyChanges",
         R"({"changes": [{"put": {"object": {"name": "ground", "shapes": [{"half_space": {}}]}}}]})"});
    std::ofstream(File("arm.urdf")) << collision::testing::Robot(collision::testing::ThreeBalls());
    CwmJson({"robot", "load", File("arm.urdf")});
  }

  json Validated(const std::string& file) const {
    const ProcessResult run = RunProgram({"node", "tests/e2e/validate_glb.mjs", file});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out);
  }
};

TEST_F(ExportCommand, WritesGlbWithoutAnythingToSayOfIt) {
  ASSERT_TRUE(std::filesystem::exists(kValidator))
      << "gltf-validator is missing: ./dev setup test installs it";
  PutObjects();
  const ProcessResult exported = Cwm({"export", File("things.glb")});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_THAT(exported.err, HasSubstr("ground: a half-space is left out"));
  const json report = Validated(File("things.glb"));
  EXPECT_EQ(report.at("issues").at("messages"), json::array());
  EXPECT_GT(report.at("info").at("totalTriangleCount"), 100);
  EXPECT_EQ(report.at("info").at("materialCount"), 3);  // user, unseen, robot
}

TEST_F(ExportCommand, WritesAnEmptyWorldToo) {
  CwmJson({"put", "can", "--cylinder", "0.03,0.1", "--at", "0,0,1"});
  CwmJson({"remove", "can"});
  ASSERT_EQ(Cwm({"export", File("empty.glb")}).exit_code, 0);
  EXPECT_EQ(Validated(File("empty.glb")).at("issues").at("numErrors"), 0);
}

TEST_F(ExportCommand, PutsMeshesBesideAModel) {
  PutObjects();
  const ProcessResult exported = Cwm({"export", File("things.urdf")});
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_THAT(exported.out, HasSubstr("and 1 mesh beside it"));
  EXPECT_TRUE(std::filesystem::exists(File("default_meshes/0_hat.stl")));
  // Our own URDF reader finds the mesh beside the file, as another tool would.
  const ProcessResult loaded = Cwm({"-w", "copy", "robot", "load", File("things.urdf")});
  EXPECT_EQ(loaded.exit_code, 0) << loaded.err;
}

TEST_F(ExportCommand, RefusesAnEndingThatItDoesNotKnow) {
  const ProcessResult refused = Cwm({"export", File("things.obj")});
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("must end in .glb, .ply, .scene, .sdf, .urdf or .yaml"));
}

}  // namespace
}  // namespace cwm::testing
