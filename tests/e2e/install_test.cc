// The result of `cmake --install`, used by somebody without our sources.
#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using ::testing::ContainsRegex;
using ::testing::HasSubstr;

class Install : public ServerTest {
 protected:
  // The build folder that contains the programs.
  static std::string BuildFolder() {
    return std::filesystem::path(Program("cwm")).parent_path().parent_path().string();
  }
  static void Succeeds(const std::vector<std::string>& arguments) {
    const ProcessResult run = RunProgram(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  }
  std::string prefix() const { return scratch() / "prefix"; }
  std::string build() const { return scratch() / "user_build"; }
  void InstallClient() const {
    ASSERT_NO_FATAL_FAILURE(Succeeds(
        {"cmake", "--install", BuildFolder(), "--prefix", prefix(), "--component", "client-dev"}));
    EXPECT_FALSE(std::filesystem::exists(prefix() + "/bin")) << "programs are other components";
  }
  // Builds a copy of the folder, as somebody without our sources does.
  void Build(const std::string& folder) const {
    const std::string source = scratch() / "user";
    std::filesystem::copy(folder, source);
    ASSERT_NO_FATAL_FAILURE(
        Succeeds({"cmake", "-S", source, "-B", build(), "-DCMAKE_PREFIX_PATH=" + prefix(),
                  "-DCMAKE_BUILD_TYPE=Debug"}));
    ASSERT_NO_FATAL_FAILURE(Succeeds({"cmake", "--build", build(), "--parallel", "2"}));
  }
  // What the example prints about the server of this test.
  std::string Example(const std::string& name) const {
    const ProcessResult run =
        RunProgram({"env", "CWM_ADDR=" + address(), "timeout", "60", build() + "/" + name});
    EXPECT_EQ(run.exit_code, 0) << name << ": " << run.err;
    return run.out;
  }
};

TEST_F(Install, LetsProgramsOutsideOfTheTreeAskAServer) {
  ASSERT_NO_FATAL_FAILURE(InstallClient());
  ASSERT_NO_FATAL_FAILURE(Build("tests/e2e/consumer"));
  ASSERT_EQ(Cwm({"put", "post", "--box", "0.2,0.2,0.2", "--at", "1,0,0"}).exit_code, 0);
  const ProcessResult finished = RunProgram({build() + "/consumer", address()});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_EQ(finished.out, "post 0.800\n") << "a ball of 0.1 m, a face at 0.9 m";
}

TEST_F(Install, BuildsTheExamplesWhichAnswerAServer) {
  ASSERT_NO_FATAL_FAILURE(InstallClient());
  ASSERT_NO_FATAL_FAILURE(Build("clients/cpp/examples"));
  // The fingers, whose tips are 0.06 m below the gripper's origin and 0.05 m from its middle, come
  // to a cup of 0.1 m height and 0.04 m radius; at last the palm is 0.01 m inside of it.
  EXPECT_EQ(Example("distances_of_a_gripper"),
            "z = 0.30 m:  cup 140.4 mm  table 240.0 mm\n"
            "z = 0.20 m:  cup 41.2 mm  table 140.0 mm\n"
            "z = 0.15 m:  cup 10.0 mm  table 90.0 mm\n"
            "z = 0.09 m:  cup -10.0 mm  table 30.0 mm\n");
  const std::string path = Example("plan_path");
  EXPECT_THAT(path, ContainsRegex("a path of [0-9]+ states around the pillar: FREE, at least"));
  EXPECT_THAT(path, HasSubstr("straight: CONTACT of lower with pillar\n"));
  // Links of 0.5 and 0.4 m are perpendicular where the hand is at (0.4, 0.5).
  EXPECT_EQ(Example("inverse_kinematics"),
            "pose 0: SOLVED\n"
            "   0.2213  1.5708 -0.2213 rad put the hand at 0.4000 0.5000 m\n"
            "   1.5708 -1.5708  1.5708 rad put the hand at 0.4000 0.5000 m\n"
            "pose 1: UNREACHABLE\n");
  EXPECT_THAT(Example("what_if"),
              ContainsRegex("as it is: FREE\n"
                            "with the tray: CONTACT, tray meets post at [0-9]+ deg\n"
                            "and without the post: FREE\n"
                            "the world is at revision 3, and the tray is free\n"));
  EXPECT_THAT(Example("ingest_scan"),
              ContainsRegex("76800 of 76800 points explained\nobject_1 at [^\n]*\n  sphere, "
                            "radius 120\\.[0-9] mm, rms"));
  EXPECT_THAT(Example("follow_sensor"), HasSubstr("overhead: 90 frames"));
  EXPECT_EQ(Example("watch_world"), "revision 2: ball\nrevision 3: ball cup\nrevision 4: cup\n");
  const ProcessResult objects = Cwm({"objects"});
  EXPECT_EQ(objects.exit_code, 3) << "no example writes into the world \"default\"" << objects.out;
}

TEST_F(Install, PutsProgramsWhereTheyRun) {
  for (const char* component : {"server", "cli"}) {
    ASSERT_NO_FATAL_FAILURE(Succeeds(
        {"cmake", "--install", BuildFolder(), "--prefix", prefix(), "--component", component}));
  }
  for (const char* program : {"cwm", "cwm-plan", "cwm-simulator", "cwm-server"}) {
    const ProcessResult help = RunProgram({prefix() + "/bin/" + program, "--help"});
    EXPECT_EQ(help.exit_code, 0) << program << help.err;
    EXPECT_THAT(help.out + help.err, HasSubstr("--")) << program;
  }
  EXPECT_FALSE(std::filesystem::exists(prefix() + "/include"));
}

}  // namespace
}  // namespace cwm::testing
