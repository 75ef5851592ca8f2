#include "tests/benchmarks/live/scene_samples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "tests/support/process.h"

namespace cwm::benchmarks {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// A scene whose samples tell its number.
bool AddNumber(int scene, SceneSamples& samples) {
  samples.Add("number", scene + 0.1);
  samples.Add("number", scene + 0.2);
  if (scene == 1) samples.Add("odd", 1);
  return true;
}

TEST(SceneSamples, ACallGoesOnAfterTheScenesOfTheOneBefore) {
  const testing::ScratchDirectory scratch;
  const SceneOptions options{.samples = scratch / "samples.txt"};  // one scene a call
  Report report;
  for (int call = 0; call < 3; ++call) {
    ASSERT_TRUE(MeasureScenes(options, "part", 10, report, AddNumber).has_value());
    ASSERT_TRUE(MeasureScenes(options, "other", 10, report, AddNumber).has_value());
  }
  const auto samples = SceneSamples::Read(options.samples, "part");
  ASSERT_TRUE(samples.ok()) << samples.status();
  EXPECT_EQ(samples->scene_count(), 3);
  EXPECT_THAT(samples->Of("number"), ElementsAre(0.1, 0.2, 1.1, 1.2, 2.1, 2.2));
  EXPECT_DOUBLE_EQ(samples->Sum("odd"), 1);
  EXPECT_THAT(samples->Of("unknown"), IsEmpty());
}

TEST(SceneSamples, NoMoreScenesAreMeasuredThanAskedFor) {
  Report report;
  const auto samples = MeasureScenes({.minutes = 1}, "part", 4, report, AddNumber);
  ASSERT_TRUE(samples.has_value());
  EXPECT_EQ(samples->scene_count(), 4);
  EXPECT_FALSE(report.failed());
}

TEST(SceneSamples, AFailedSceneKeepsNothing) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "samples.txt";
  Report report;
  const auto fails = [](int, SceneSamples& samples) {
    samples.Add("number", 1);
    return false;
  };
  EXPECT_FALSE(MeasureScenes({.samples = path}, "part", 4, report, fails).has_value());
  EXPECT_EQ(SceneSamples::Read(path, "part")->scene_count(), 0);
}

TEST(SceneSamples, AFileOfSomethingElseIsRefusedByItsLine) {
  const testing::ScratchDirectory scratch;
  const std::string path = scratch / "samples.txt";
  for (const char* line : {"part number 2 0.5 many\n", "part number 2 0.5\n", "part number\n"}) {
    std::ofstream(path) << "other\n" << line;
    const auto samples = SceneSamples::Read(path, "part");
    EXPECT_THAT(samples.status().message(), HasSubstr("line 2")) << line;
  }
}

}  // namespace
}  // namespace cwm::benchmarks
