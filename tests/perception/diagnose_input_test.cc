// Input that contradicts its description: the report warns of it, and does not warn of correct
// scans.
#include "perception/diagnose_input.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "perception/simulation/unorganised.h"
#include "tests/perception/table_scene.h"

namespace cwm::perception {
namespace {

using ::testing::Contains;
using ::testing::ContainsRegex;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

using Warnings = std::vector<std::string>;

SimulatedScene BoxAndCan() {
  return {{Table(), MakeObject("box", Box{{0.1, 0.14, 0.16}}, MakeTranslation(0.05, -0.25, 0.08)),
           MakeObject("can", Cylinder{0.06, 0.18}, MakeTranslation(0, 0.1, 0.09))}};
}

SensorNoise OfSigma(double sigma_m) {
  return {.model = SensorModel::kGiven, .given_sigma_m = sigma_m};
}

SimulatedCloud SeenBy(const SensorNoise& noise) {
  return Scan(BoxAndCan(), TableCamera(), {.noise = noise});
}

Warnings WarningsOf(const PointCloud& cloud, const InterpretOptions& options) {
  const auto scene = InterpretScene(cloud, options);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return scene.ok() ? scene->report.warnings : Warnings{};
}

Warnings WarningsSaidToBeOf(const SensorNoise& noise, const PointCloud& cloud) {
  InterpretOptions options;
  options.noise = noise;
  options.X_WC = TableCamera().X_WC;
  return WarningsOf(cloud, options);
}

std::vector<SensorNoise> Sensors() {
  return {{},
          {.model = SensorModel::kRealSense},
          {.model = SensorModel::kTimeOfFlight},
          OfSigma(1e-4),
          OfSigma(1e-3),
          OfSigma(5e-3)};
}

TEST(DiagnoseInput, SaysNothingOfASensorThatIsTheOneItIsSaidToBe) {
  for (const SensorNoise& noise : Sensors()) {
    const SimulatedCloud seen = SeenBy(noise);
    EXPECT_THAT(WarningsSaidToBeOf(noise, seen.cloud), Not(Contains(HasSubstr("scatter"))));
    EXPECT_THAT(WarningsSaidToBeOf(noise, Shuffled(seen, 1).cloud),
                Not(Contains(HasSubstr("scatter"))));
  }
}

TEST(DiagnoseInput, DoubtsASensorWhosePointsScatterFarMore) {
  const auto too_small = Contains(HasSubstr("is it another sensor's, or sigma too small?"));
  EXPECT_THAT(WarningsSaidToBeOf({}, SeenBy({.model = SensorModel::kRealSense}).cloud), too_small);
  EXPECT_THAT(WarningsSaidToBeOf({}, SeenBy({.model = SensorModel::kTimeOfFlight}).cloud),
              too_small);
  EXPECT_THAT(WarningsSaidToBeOf(OfSigma(2e-4), SeenBy({}).cloud), too_small);
  EXPECT_THAT(WarningsSaidToBeOf(OfSigma(2e-4), Shuffled(SeenBy({}), 1).cloud), too_small);
}

// A Kinect's noise model suits points without noise as well: little accuracy is lost.
TEST(DiagnoseInput, DoubtsAGivenSigmaThatIsFarTooLarge) {
  const PointCloud cloud = SeenBy(OfSigma(1e-3)).cloud;
  EXPECT_THAT(WarningsSaidToBeOf(OfSigma(0.05), cloud),
              Contains(HasSubstr("small objects may be missed")));
  EXPECT_THAT(WarningsSaidToBeOf({}, cloud), Not(Contains(HasSubstr("scatter"))));
}

TEST(DiagnoseInput, DoubtsUnitsByWhatTheSensorSees) {
  const auto warnings_at = [](float scale) {
    PointCloud cloud = SeenBy({}).cloud;
    for (Eigen::Vector3f& p : cloud.points) p *= scale;
    return WarningsSaidToBeOf({}, cloud);
  };
  const auto too_far =
      Contains(HasSubstr("a Kinect sees nothing: coordinates are metres; for millimetres"));
  const auto too_near = Contains(ContainsRegex("nearer than 0.1 m, where a Kinect sees nothing"));
  for (const float scale : {100.0f, 1000.0f}) EXPECT_THAT(warnings_at(scale), too_far) << scale;
  EXPECT_THAT(warnings_at(0.001f), too_near);
  EXPECT_THAT(warnings_at(1), Not(Contains(HasSubstr("sees nothing"))));
}

// Normals that are unknown (zero), random, or the normal of the table at every point.
TEST(DiagnoseInput, DoubtsGivenNormalsThatContradictTheSurface) {
  const auto contradict = Contains(HasSubstr("normals contradict the surfaces"));
  PointCloud cloud = SeenBy({}).cloud;
  cloud.normals.assign(cloud.size(), Eigen::Vector3f::Zero());
  EXPECT_THAT(WarningsSaidToBeOf({}, cloud), Not(contradict)) << "zero: unknown";
  std::mt19937 random(1);
  std::normal_distribution<float> component;
  for (Eigen::Vector3f& n : cloud.normals) {
    n = Eigen::Vector3f(component(random), component(random), component(random)).normalized();
  }
  EXPECT_THAT(WarningsSaidToBeOf({}, cloud), contradict);
  // The normal of the table, to which most points belong.
  const Eigen::Vector3f up_C = TableCamera().X_WC.linear().row(2).transpose().cast<float>();
  cloud.normals.assign(cloud.size(), up_C);
  EXPECT_THAT(WarningsSaidToBeOf({}, cloud), Not(contradict));
}

// Too little stands on the table to tell which side is its upper one; the sensor's position tells
// it.
TEST(DiagnoseInput, DoubtsAnUpThatIsUpsideDownOfACloudThatIsNoImage) {
  const SimulatedScene ball{
      {Table(), MakeObject("ball", Sphere{0.03}, MakeTranslation(0, 0, 0.03))}};
  const PointCloud cloud = Shuffled(Scan(ball, TableCamera(), {}), 1).cloud;
  const auto upside_down = Contains(HasSubstr("may be upside down"));
  InterpretOptions options;
  options.up_C = TableCamera().X_WC.linear().row(2).transpose();
  EXPECT_THAT(WarningsOf(cloud, options), Not(upside_down));
  *options.up_C *= -1;
  EXPECT_THAT(WarningsOf(cloud, options), upside_down);
}

// The pose of the camera's body is given instead of that of its optical frame, or no pose at all.
TEST(DiagnoseInput, SaysHowFarTheTableIsFromLevelByAPoseThatIsWrong) {
  InterpretOptions options;
  options.X_WC = Pose::Identity();
  const PointCloud cloud = SeenBy({}).cloud;
  // 35 degrees down, from along z to along the table's normal.
  EXPECT_THAT(WarningsOf(cloud, options),
              Contains(HasSubstr("is 125 degrees from level by the pose")));
  options.X_WC.reset();
  options.up_C = Vector3::UnitX();
  EXPECT_THAT(WarningsOf(cloud, options),
              Contains(HasSubstr("is 90 degrees from level by the up")));
  const SimulatedScene wall{{MakeObject("wall", Box{{0.1, 4, 4}}, MakeTranslation(0.5, 0, 0))}};
  options.up_C = TableCamera().X_WC.linear().row(2).transpose();
  EXPECT_THAT(WarningsOf(Scan(wall, TableCamera(), {}).cloud, options),
              Not(Contains(HasSubstr("from level"))));
}

TEST(DiagnoseInput, SaysNothingOfAGoodScan) {
  EXPECT_THAT(WarningsSaidToBeOf({}, SeenBy({}).cloud), IsEmpty());
}

}  // namespace
}  // namespace cwm::perception
