#include "clients/simulator/simulated_files.h"

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "perception/simulation/random_scenes.h"

namespace cwm::simulator {
namespace {

using perception::PieceRole;
using perception::SceneFamily;
using perception::SimulatedView;

SimulatedScan ScanOf(const SimulatedView& view) {
  return {.cloud = perception::Scan(view.scene, view.camera, {}), .up_C = {0, -1, 0}};
}

// Checks the labels without the code that made them.
TEST(TrueLabels, FollowTheSchemeDownToTheParts) {
  const SimulatedView view = RandomScene(SceneFamily::kVessels, 1);
  const SimulatedScan scan = ScanOf(view);
  const std::vector<std::uint32_t> labels = TrueLabels(view.scene, scan.cloud);
  ASSERT_EQ(labels.size(), scan.cloud.cloud.points.size());
  std::map<std::int32_t, std::uint32_t> number_of;
  std::uint32_t supports = 0;
  std::uint32_t things = 0;
  for (std::size_t i = 0; i < view.scene.objects.size(); ++i) {
    number_of[static_cast<std::int32_t>(i)] =
        view.scene.objects[i].is_support ? ++supports : ++things;
  }
  std::set<std::uint32_t> handle_labels;
  for (std::size_t p = 0; p < labels.size(); ++p) {
    const std::int32_t index = scan.cloud.object[p];
    if (index < 0) {
      ASSERT_EQ(labels[p], 0U);
      continue;
    }
    const auto& object = view.scene.objects[static_cast<std::size_t>(index)];
    if (object.is_support) {
      ASSERT_EQ(labels[p], number_of[index]);
      continue;
    }
    ASSERT_EQ(labels[p] / 10, number_of[index] + 1);
    const auto part = static_cast<std::uint32_t>(scan.cloud.part[p]);
    ASSERT_EQ(labels[p] % 10, object.parts.size() == 1 ? 0 : part + 1);
    if (object.RoleOf(part) == PieceRole::kHandle) handle_labels.insert(labels[p]);
  }
  EXPECT_GT(handle_labels.size(), 0U);
}

TEST(Truth, CountsTheLabelsAndSharesThatTheCloudShows) {
  const SimulatedView view = RandomScene(SceneFamily::kVessels, 3);
  const SimulatedScan scan = ScanOf(view);
  std::map<std::uint32_t, int> points_of;
  for (const std::uint32_t label : TrueLabels(view.scene, scan.cloud)) ++points_of[label];
  const auto truth = nlohmann::json::parse(TruthJson(view.scene, view.camera, scan));
  ASSERT_EQ(truth.at("objects").size(), view.scene.objects.size());
  bool any_handle = false;
  for (const auto& object : truth.at("objects")) {
    EXPECT_GE(object.at("hidden_fraction"), 0);
    EXPECT_LE(object.at("hidden_fraction"), 1);
    int sum = 0;
    for (const auto& part : object.at("parts")) {
      EXPECT_EQ(part.at("visible_points"), points_of[part.at("label")]) << object.at("name");
      sum += part.at("visible_points").get<int>();
      any_handle = any_handle || part.at("role") == "handle";
    }
    EXPECT_EQ(object.at("visible_points"), sum);
  }
  EXPECT_TRUE(any_handle);
  EXPECT_EQ(truth.at("up_sensor"), nlohmann::json({0.0, -1.0, 0.0}));
  EXPECT_EQ(truth.at("camera").at("focal_px"), view.camera.focal_px);
  EXPECT_FALSE(truth.contains("views"));
}

TEST(Truth, TellsWhereSeveralViewsWereAndWhereTheyAreBelievedToBe) {
  const SimulatedView view = RandomScene(SceneFamily::kTable, 1);
  SimulatedScan scan = ScanOf(view);
  scan.X_WC = {view.camera.X_WC, MakeTranslation(1, 2, 3)};
  scan.X_CC = {Pose::Identity(), MakeTranslation(4, 5, 6)};
  const auto truth = nlohmann::json::parse(TruthJson(view.scene, view.camera, scan));
  ASSERT_EQ(truth.at("views").size(), 2U);
  EXPECT_EQ(truth.at("views")[1].at("x_world_sensor").at("ty_m"), 2);
  EXPECT_EQ(truth.at("views")[1].at("x_first_sensor_registered").at("tz_m"), 6);
}

TEST(Truth, LeavesOutBoundsThatAreInfinite) {
  SimulatedView view = RandomScene(SceneFamily::kTable, 1);
  view.scene.objects.push_back(
      {.name = "ground", .parts = {{.shape = HalfSpace{}}}, .is_support = true});
  const auto truth = nlohmann::json::parse(TruthJson(view.scene, view.camera, ScanOf(view)));
  EXPECT_TRUE(truth.at("objects").back().at("size_m")[0].is_null());
}

}  // namespace
}  // namespace cwm::simulator
