#include "tests/benchmarks/quality/simulated_case.h"

#include <utility>

#include "perception/interpret_scene.h"
#include "perception/simulation/several_views.h"
#include "perception/simulation/unorganised.h"

namespace cwm::benchmarks {
namespace {

using perception::SceneFamily;

// The pose X_BC of a camera that looks along a body's x axis, with its rows across z.
Pose BodyOfCamera() {
  Pose X_BC = Pose::Identity();
  X_BC.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return X_BC;
}

}  // namespace

std::vector<SceneFamily> AllFamilies() {
  std::vector<SceneFamily> families;
  for (const auto& [name, family] : perception::kSceneFamilies) families.push_back(family);
  return families;
}

bool IsFurniture(const perception::SimulatedObject& object) {
  return object.is_support || object.name == "wall" || object.name == "cabinet" ||
         object.name.starts_with("front_");
}

std::string_view FamilyName(SceneFamily family) {
  return perception::kSceneFamilies[static_cast<std::size_t>(family)].name;
}

std::string NameOf(const CaseName& name) {
  return std::string(FamilyName(name.family)) + " " + std::to_string(name.seed);
}

std::optional<SceneFamily> FamilyNamed(std::string_view name) {
  for (const auto& [text, family] : perception::kSceneFamilies) {
    if (text == name) return family;
  }
  return std::nullopt;
}

std::string FamilyNames() {
  std::string names;
  for (const auto& [text, family] : perception::kSceneFamilies) {
    names += (names.empty() ? "" : ", ") + std::string(text);
  }
  return names;
}

SimulatedCase ScanCase(const CaseName& name, const CaseSensor& sensor) {
  SimulatedCase result;
  result.noise = sensor.noise;
  result.simulated = perception::RandomScene(name.family, name.seed);
  const perception::SimulatedView& view = result.simulated;
  const perception::ScanOptions scanning{
      .noise = sensor.noise, .matches_windows = sensor.matches_windows, .seed = name.seed};
  result.scan = sensor.form == CloudForm::kThreeViews
                    ? ScanFromSeveralViews(view.scene, view.camera, 3, scanning).cloud
                    : Scan(view.scene, view.camera, scanning);
  if (sensor.form == CloudForm::kShuffled) result.scan = Shuffled(result.scan, name.seed);
  return result;
}

absl::Status InterpretCase(const CaseName& name, const CaseSensor& sensor,
                           const std::vector<std::string>& disabled_passes,
                           SimulatedCase& scanned) {
  // B: the frame in which the interpreter gets the cloud.
  const Pose X_BC = sensor.form == CloudForm::kBodyImage ? BodyOfCamera() : Pose::Identity();
  perception::PointCloud cloud = scanned.scan.cloud;
  for (Eigen::Vector3f& p : cloud.points) p = (X_BC * p.cast<double>()).cast<float>();
  perception::InterpretOptions options;
  options.max_threads = 1;
  options.noise = sensor.noise;
  options.disabled_passes = disabled_passes;
  if (name.seed % 2 == 0) options.X_WC = scanned.simulated.camera.X_WC * X_BC.inverse();
  auto interpretation = perception::InterpretScene(cloud, options);
  if (!interpretation.ok()) return interpretation.status();
  scanned.interpretation = *std::move(interpretation);
  scanned.interpretation.X_WC = scanned.interpretation.X_WC * X_BC;
  return absl::OkStatus();
}

absl::StatusOr<SimulatedCase> RunCase(const CaseName& name, const CaseSensor& sensor) {
  SimulatedCase result = ScanCase(name, sensor);
  if (absl::Status status = InterpretCase(name, sensor, {}, result); !status.ok()) return status;
  return result;
}

}  // namespace cwm::benchmarks
