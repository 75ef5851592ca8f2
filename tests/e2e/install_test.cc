// The result of `cmake --install`, used by somebody without our sources.
#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <vector>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

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
};

TEST_F(Install, LetsAProgramOutsideOfTheTreeAskAServer) {
  ASSERT_NO_FATAL_FAILURE(Succeeds(
      {"cmake", "--install", BuildFolder(), "--prefix", prefix(), "--component", "client-dev"}));
  EXPECT_FALSE(std::filesystem::exists(prefix() + "/bin")) << "programs are other components";
  const std::string source = scratch() / "consumer", build = scratch() / "consumer_build";
  std::filesystem::copy("tests/e2e/consumer", source);
  ASSERT_NO_FATAL_FAILURE(
      Succeeds({"cmake", "-S", source, "-B", build, "-DCMAKE_PREFIX_PATH=" + prefix(),
                "-DCMAKE_BUILD_TYPE=Debug"}));
  ASSERT_NO_FATAL_FAILURE(Succeeds({"cmake", "--build", build}));
  ASSERT_EQ(Cwm({"put", "post", "--box", "0.2,0.2,0.2", "--at", "1,0,0"}).exit_code, 0);
  const ProcessResult finished = RunProgram({build + "/consumer", address()});
  EXPECT_EQ(finished.exit_code, 0) << finished.err;
  EXPECT_EQ(finished.out, "post 0.800\n") << "a ball of 0.1 m, a face at 0.9 m";
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
