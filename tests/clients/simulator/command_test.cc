// The program itself, run as by a shell.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "clients/formats/cloud_reader.h"
#include "clients/formats/file_bytes.h"
#include "tests/support/process.h"

namespace cwm::simulator {
namespace {

using ::testing::HasSubstr;
using testing::ProcessResult;
using testing::ScratchDirectory;

constexpr int kUsage = 1;
constexpr int kBadInput = 8;

ProcessResult Simulate(std::vector<std::string> arguments) {
  const char* folder = std::getenv("CWM_BIN");
  arguments.insert(arguments.begin(),
                   std::string(folder == nullptr ? "." : folder) + "/cwm-simulator");
  return testing::RunProgram(arguments);
}

nlohmann::json ReadJson(const std::string& path) {
  return nlohmann::json::parse(formats::ReadFileBytes(path).value());
}

formats::CloudFile ReadCloudFile(const std::string& path) {
  return formats::ReadCloud(path).value();
}

TEST(Simulator, SeesTheSameInASceneThatItWrote) {
  const ScratchDirectory scratch;
  const ProcessResult made =
      Simulate({"--random", "vessels", "--seed", "5", "--noiseless", "--write-scene",
                scratch / "s.yaml", "--out", scratch / "a.pcd", "--truth", scratch / "a.json"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  const ProcessResult read = Simulate({"--scene", scratch / "s.yaml", "--noiseless", "--out",
                                       scratch / "b.pcd", "--truth", scratch / "b.json"});
  ASSERT_EQ(read.exit_code, 0) << read.err;
  const auto a = ReadJson(scratch / "a.json");
  const auto b = ReadJson(scratch / "b.json");
  ASSERT_EQ(a.at("objects").size(), b.at("objects").size());
  for (std::size_t i = 0; i < a.at("objects").size(); ++i) {
    const auto& x = a.at("objects")[i];
    const auto& y = b.at("objects")[i];
    EXPECT_EQ(x.at("name"), y.at("name"));
    EXPECT_EQ(x.at("label"), y.at("label"));
    // Rounded poses change at most a pixel of the border.
    EXPECT_NEAR(x.at("visible_points").get<double>(), y.at("visible_points").get<double>(), 2);
  }
}

TEST(Simulator, GivesTheSameBytesForTheSameSeed) {
  const ScratchDirectory scratch;
  const std::vector<std::string> names = {scratch / "1.pcd", scratch / "2.pcd", scratch / "3.pcd"};
  const std::vector<std::string> seeds = {"4", "4", "5"};
  for (std::size_t i = 0; i < names.size(); ++i) {
    ASSERT_EQ(Simulate({"--random", "table", "--seed", seeds[i], "--labels", "--out", names[i]})
                  .exit_code,
              0);
  }
  EXPECT_EQ(formats::ReadFileBytes(names[0]).value(), formats::ReadFileBytes(names[1]).value());
  EXPECT_NE(formats::ReadFileBytes(names[0]).value(), formats::ReadFileBytes(names[2]).value());
}

TEST(Simulator, TakesEverySensor) {
  const ScratchDirectory scratch;
  for (const char* sensor :
       {"kinect", "realsense", "time_of_flight", "tilting_laser", "sick_lms400", "0.003"}) {
    const ProcessResult run = Simulate({"--sensor", sensor, "--out", scratch / "a.pcd"});
    EXPECT_EQ(run.exit_code, 0) << sensor << run.err;
    EXPECT_EQ(ReadCloudFile(scratch / "a.pcd").size(), 640 * 480);
  }
}

TEST(Simulator, PutsViewsTogetherAndShuffles) {
  const ScratchDirectory scratch;
  const ProcessResult run =
      Simulate({"--views", "3", "--shuffle", "--up-error-deg", "2", "--labels", "--out",
                scratch / "a.pcd", "--truth", scratch / "a.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const formats::CloudFile cloud = ReadCloudFile(scratch / "a.pcd");
  EXPECT_EQ(cloud.height, 1);
  EXPECT_GT(cloud.width, 2 * 640 * 480);
  EXPECT_NE(cloud.Find("label"), nullptr);
  const auto truth = ReadJson(scratch / "a.json");
  EXPECT_EQ(truth.at("views").size(), 3U);
  EXPECT_EQ(truth.at("width"), cloud.width);
  EXPECT_EQ(truth.at("height"), 1);
}

TEST(Simulator, SaysWhatIsWrong) {
  const ScratchDirectory scratch;
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string says;
  };
  for (const Case& wrong : {
           Case{{"--scene", scratch / "none.yaml", "--out", scratch / "a.pcd"},
                kBadInput,
                "none.yaml"},
           Case{{"--sensor", "sonar", "--out", scratch / "a.pcd"}, kBadInput, "sick_lms400"},
           Case{{}, kBadInput, "--out is missing"},
           Case{{"--random", "garden", "--out", scratch / "a.pcd"}, kUsage, "garden"},
           Case{{"--random", "table", "--scene", "kitchen", "--out", scratch / "a.pcd"},
                kUsage,
                "--scene"},
           Case{{"--views", "0", "--out", scratch / "a.pcd"}, kUsage, "--views"},
           Case{{"--up-error-deg", "nan", "--out", scratch / "a.pcd"}, kBadInput, "finite"},
       }) {
    const ProcessResult run = Simulate(wrong.arguments);
    EXPECT_EQ(run.exit_code, wrong.exit_code) << wrong.says << run.err;
    EXPECT_THAT(run.err, HasSubstr(wrong.says));
  }
}

TEST(Simulator, WritesASequenceOfAScript) {
  const ScratchDirectory scratch;
  ASSERT_TRUE(formats::WriteFileBytes(scratch / "s.yaml",
                                      "scene: table\nduration_s: 0.1\nsensors: [{name: a}]\n")
                  .ok());
  const ProcessResult made = Simulate({"--script", scratch / "s.yaml", "--out", scratch / "out"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  EXPECT_EQ(ReadJson(scratch / "out/a/camera.json").at("width"), 640);
  EXPECT_EQ(ReadJson(scratch / "out/sequence.json").at("objects").size(), 9U);
  for (const char* name : {"out/a/000000.png", "out/a/000002.png", "out/a/frames.jsonl"}) {
    EXPECT_TRUE(formats::ReadFileBytes(scratch / name).ok()) << name;
  }
}

TEST(Simulator, RefusesASequenceWithOptionsOfScans) {
  const ProcessResult both = Simulate({"--script", "s.yaml", "--out", "o", "--sensor", "kinect"});
  EXPECT_EQ(both.exit_code, kUsage);
  EXPECT_THAT(both.err, HasSubstr("--sensor excludes --script"));
  const ProcessResult missing = Simulate({"--script", "no_such.yaml", "--out", "o"});
  EXPECT_EQ(missing.exit_code, kBadInput);
  EXPECT_THAT(missing.err, HasSubstr("no_such.yaml"));
  EXPECT_EQ(Simulate({"--script", "s.yaml"}).exit_code, kBadInput);
}

}  // namespace
}  // namespace cwm::simulator
