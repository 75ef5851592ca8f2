#include "tests/benchmarks/quality/simulated_case.h"

#include <array>
#include <utility>

#include "perception/interpret_scene.h"

namespace cwm::benchmarks {
namespace {

using perception::SceneFamily;

// In the order of the families.
constexpr std::array<std::pair<SceneFamily, std::string_view>, 4> kFamilies = {
    {{SceneFamily::kTable, "table"},
     {SceneFamily::kClutter, "clutter"},
     {SceneFamily::kKitchen, "kitchen"},
     {SceneFamily::kVessels, "vessels"}}};

}  // namespace

std::string_view FamilyName(SceneFamily family) {
  return kFamilies[static_cast<std::size_t>(family)].second;
}

std::string NameOf(const CaseName& name) {
  return std::string(FamilyName(name.family)) + " " + std::to_string(name.seed);
}

std::optional<SceneFamily> FamilyNamed(std::string_view name) {
  for (const auto& [family, text] : kFamilies) {
    if (text == name) return family;
  }
  return std::nullopt;
}

absl::StatusOr<SimulatedCase> RunCase(const CaseName& name, const perception::SensorNoise& noise) {
  SimulatedCase result;
  result.noise = noise;
  result.simulated = perception::RandomScene(name.family, name.seed);
  const perception::SimulatedView& view = result.simulated;
  result.scan = perception::Scan(view.scene, view.camera, {.noise = noise, .seed = name.seed});
  perception::InterpretOptions options;
  options.max_threads = 1;
  options.noise = noise;
  if (name.seed % 2 == 0) options.X_WC = view.camera.X_WC;
  auto interpretation = perception::InterpretScene(result.scan.cloud, options);
  if (!interpretation.ok()) return interpretation.status();
  result.interpretation = *std::move(interpretation);
  return result;
}

}  // namespace cwm::benchmarks
