// Real scans and real planning scenes, if they are available.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/e2e/server_fixture.h"
#include "tests/support/outside_data.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

std::vector<std::string> FilesWith(const std::string& directory, const std::string& extension) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(directory)) {
    if (entry.path().extension() == extension) files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  return files;
}

class RealScans : public ServerTest {};

TEST_F(RealScans, EachGivesOneSupportAndObjectsInAWorldOfItsOwnAndAllFitIntoOne) {
  const auto directory = OutsideData("mosd/learn");
  if (!directory) GTEST_SKIP() << "labelled Kinect scans (mosd/learn) are not in CWM_DATA";
  const std::vector<std::string> scans = FilesWith(*directory, ".pcd");
  ASSERT_EQ(scans.size(), 45U);
  const auto expect_a_table = [&](const std::string& scan, const std::string& world) {
    // One world holds other tables after each other, as a sensor that moves without a word.
    const json answer = CwmJson({"ingest", scan, "--world", world, "--force"});
    ASSERT_TRUE(answer.is_object()) << scan;
    EXPECT_EQ(answer.at("supports").size(), 1U) << scan << " into " << world;
    const auto is_object = [](const json& o) { return o.at("kind") == "OBJECT_KIND_OBJECT"; };
    EXPECT_GE(std::count_if(answer["objects"].begin(), answer["objects"].end(), is_object), 1)
        << scan << " into " << world;
  };
  for (const std::string& scan : scans) expect_a_table(scan, std::filesystem::path(scan).stem());
  const double after_45_worlds = server().ResidentMebibytes();
  for (const std::string& scan : scans) expect_a_table(scan, "all");
  // 45 worlds of about 10 objects with meshes, then one world that keeps its last revisions. A leak
  // of whole clouds would take 45 x 307 200 points x 12 bytes = 160 MiB in each round.
  EXPECT_LT(after_45_worlds, 1500);
  EXPECT_LT(server().ResidentMebibytes(), after_45_worlds + 500);
}

TEST_F(RealScans, TheSameScanTwiceMakesNoRevision) {
  const auto directory = OutsideData("mosd/learn");
  if (!directory) GTEST_SKIP() << "labelled Kinect scans (mosd/learn) are not in CWM_DATA";
  const std::vector<std::string> scans = FilesWith(*directory, ".pcd");
  ASSERT_GE(scans.size(), 3U);
  // Three scans, so that the test takes seconds.
  for (const std::size_t i : {std::size_t{0}, scans.size() / 2, scans.size() - 1}) {
    SCOPED_TRACE(scans[i]);
    const std::string world = std::filesystem::path(scans[i]).stem();
    const json first = CwmJson({"ingest", scans[i], "--world", world});
    ASSERT_TRUE(first.is_object());
    EXPECT_EQ(first.at("revision"), "1");
    const json before = CwmJson({"objects", "--world", world}).at("objects");
    const json again = CwmJson({"ingest", scans[i], "--world", world});
    EXPECT_EQ(again.at("revision"), "1");
    EXPECT_EQ(again.at("changes").at("kept").size(), before.size()) << again.at("changes");
    json after = CwmJson({"objects", "--world", world}).at("objects");
    ASSERT_EQ(after.size(), before.size());
    // The time of the last observation is not part of a revision.
    for (std::size_t k = 0; k < after.size(); ++k)
      after[k]["last_observed"] = before[k]["last_observed"];
    EXPECT_EQ(after, before);
  }
}

class PlanningScenes : public ServerTest {};

// The number of primitives in a MoveIt scene of MotionBenchMaker, in which each object has one list
// of one primitive.
std::size_t PrimitivesIn(const std::string& scene) {
  std::ifstream file(scene);
  std::size_t count = 0;
  for (std::string line; std::getline(file, line);) count += line.find("primitives:") != line.npos;
  return count;
}

TEST_F(PlanningScenes, ImportPutsEveryPrimitiveIntoTheWorld) {
  const auto directory = OutsideData("motion_bench_maker/panda/problems");
  if (!directory) GTEST_SKIP() << "planning scenes (motion_bench_maker) are not in CWM_DATA";
  for (const auto& family : std::filesystem::directory_iterator(*directory)) {
    const std::string scene = family.path() / "scene0001.yaml";
    const std::string world = family.path().filename();
    const ProcessResult run = Cwm({"import", scene, "--world", world});
    ASSERT_EQ(run.exit_code, 0) << scene << ": " << run.err;
    const json objects = CwmJson({"objects", "--world", world}).at("objects");
    std::size_t shapes = 0;
    for (const json& object : objects) shapes += object.at("shapes").size();
    EXPECT_EQ(shapes, PrimitivesIn(scene)) << scene;
  }
}

}  // namespace
}  // namespace cwm::testing
