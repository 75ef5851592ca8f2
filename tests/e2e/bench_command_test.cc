// `cwm bench` on a real server: its output, and that it leaves nothing behind.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

// Short, since the output is tested, not the speed of this machine.
constexpr char kSeconds[] = "0.05";

constexpr char kUrdf[] = R"(<robot name="arm"><link name="base"/>
<link name="hand"><collision><origin xyz="0.5 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
<joint name="shoulder" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1"/></joint></robot>
)";

class BenchCommand : public ServerTest {
 protected:
  std::set<std::string> Worlds() const {
    std::set<std::string> names;
    const json listed = CwmJson({"call", "ListWorlds"});
    for (const json& world : listed.at("worlds")) {
      names.insert(world.at("name").get<std::string>());
    }
    return names;
  }
  std::set<std::string> Measured(const json& report) const {
    std::set<std::string> of;
    for (const json& line : report.at("measurements")) {
      of.insert(line.at("of").get<std::string>() + " " + line.at("through").get<std::string>());
      EXPECT_GT(line.at("rows_per_s").get<double>(), 0);
      EXPECT_GE(line.at("calls").get<int>(), line.at("repetitions").get<int>());
      EXPECT_LE(line.at("least_rows_per_s"), line.at("rows_per_s"));
      EXPECT_LE(line.at("rows_per_s"), line.at("most_rows_per_s"));
    }
    return of;
  }
};

TEST_F(BenchCommand, NeedsNoWorldAndLeavesNone) {
  const json report = CwmJson({"bench", "--seconds", kSeconds, "--batch", "100"});
  EXPECT_EQ(
      Measured(report),
      (std::set<std::string>{"distances unary", "distances stream", "body checks unary",
                             "body checks stream", "sample points unary", "sample points stream"}));
  EXPECT_EQ(report.at("address"), address());
  EXPECT_EQ(report.at("transport"), "Unix socket");
  EXPECT_EQ(report.at("is_own_world"), true);
  EXPECT_EQ(report.at("server_version"), CwmJson({"info"}).at("version"));
  EXPECT_TRUE(Worlds().empty());
}

TEST_F(BenchCommand, MeasuresWritesInWorldsOfItsOwn) {
  CwmJson({"put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0"});
  const json report = CwmJson({"bench", "--seconds", kSeconds, "--batch", "10", "--writes"});
  EXPECT_EQ(Measured(report).count("changes unary"), 1u);
  EXPECT_EQ(Measured(report).count("scans upload"), 1u);
  EXPECT_EQ(report.at("measurements").back().at("rows_per_call"), 640 * 480);
  EXPECT_EQ(RevisionOf("default"), 1);
  EXPECT_EQ(Worlds(), std::set<std::string>{"default"});
}

TEST_F(BenchCommand, AsksTheWorldOfARobotAsItIs) {
  std::ofstream(scratch() / "arm.urdf") << kUrdf;
  CwmJson({"robot", "load", scratch() / "arm.urdf", "--world", "cell"});
  CwmJson({"put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0", "--world", "cell"});
  const json report = CwmJson(
      {"bench", "--world", "cell", "--robot", "arm", "--seconds", kSeconds, "--batch", "100"});
  EXPECT_EQ(Measured(report).count("robot states unary"), 1u);
  EXPECT_EQ(Measured(report).count("robot states stream"), 1u);
  EXPECT_EQ(report.at("world"), "cell");
  EXPECT_EQ(report.at("is_own_world"), false);
  EXPECT_EQ(report.at("object_count"), 1);
  EXPECT_EQ(report.at("robot_count"), 1);
  EXPECT_EQ(RevisionOf("cell"), 2);
  EXPECT_EQ(Worlds(), std::set<std::string>{"cell"});
}

TEST_F(BenchCommand, SaysItToPeopleAndLineByLine) {
  const ProcessResult table = Cwm({"bench", "--seconds", kSeconds, "--batch", "100"});
  EXPECT_EQ(table.exit_code, 0) << table.err;
  EXPECT_THAT(table.out,
              AllOf(HasSubstr("QUESTION"), HasSubstr("sample points"), HasSubstr("p50 ms"),
                    HasSubstr("removed again: 30 shapes"), HasSubstr("on its answers")));
  const ProcessResult lines =
      Cwm({"bench", "--seconds", kSeconds, "--batch", "100", "-o", "ndjson"});
  std::istringstream in(lines.out);
  int count = 0;
  for (std::string line; std::getline(in, line); ++count) {
    EXPECT_TRUE(json::parse(line).contains("p50_ms")) << line;
  }
  EXPECT_EQ(count, 8);
}

TEST_F(BenchCommand, RemovesItsWorldWhenItIsInterrupted) {
  BackgroundProcess bench({Program("cwm"), "--addr", address(), "bench", "--seconds", "60"},
                          scratch() / "bench.log");
  // The bench's world exists before anything is measured.
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (Worlds().empty() && std::chrono::steady_clock::now() < deadline) {
  }
  ASSERT_EQ(Worlds().size(), 1u);
  EXPECT_THAT(*Worlds().begin(), ::testing::StartsWith("cwm-bench-"));
  bench.Signal(SIGINT);
  EXPECT_EQ(bench.Stop(), 5);
  EXPECT_TRUE(Worlds().empty());
}

TEST_F(BenchCommand, NamesWhatIsNotThere) {
  const ProcessResult batch = Cwm({"bench", "--batch", "65537"});
  EXPECT_EQ(batch.exit_code, 1);
  EXPECT_THAT(batch.err, HasSubstr("--batch is 65537, must be at most 65536"));
  EXPECT_EQ(Cwm({"bench", "--world", "nowhere"}).exit_code, 3);
  CwmJson({"put", "crate", "--box", "0.2,0.2,0.2", "--at", "0,0,0"});
  const ProcessResult robot = Cwm({"bench", "--robot", "ghost"});
  EXPECT_EQ(robot.exit_code, 3);
  EXPECT_THAT(robot.err, HasSubstr("there is no robot \"ghost\""));
}

}  // namespace
}  // namespace cwm::testing
