// One random scene, scanned and interpreted as an ingest would be: reproducible from family and
// seed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/simulation/random_scenes.h"
#include "tests/benchmarks/quality/seen_shapes.h"

namespace cwm::benchmarks {

struct CaseName {
  perception::SceneFamily family = perception::SceneFamily::kTable;
  std::uint64_t seed = 0;
};

// The name of a case, such as "table 17".
std::string NameOf(const CaseName& name);
std::vector<perception::SceneFamily> AllFamilies();
// True for a support, a wall or a front of a random scene.
bool IsFurniture(const perception::SimulatedObject& object);
std::string_view FamilyName(perception::SceneFamily family);
std::optional<perception::SceneFamily> FamilyNamed(std::string_view name);
std::string FamilyNames();  // of all families, "table, clutter, ..."

struct SimulatedCase {
  perception::SimulatedView simulated;
  perception::SimulatedCloud scan;
  perception::SceneInterpretation interpretation;
  perception::SensorNoise noise;

  InterpretedView view() const {
    return {simulated.scene, simulated.camera, scan, interpretation, noise};
  }
};

// The form in which the cloud reaches the interpreter: as the image of a camera, z forward; in the
// frame of a body, x forward and z up; as points in any order; or as registered points of three
// cameras.
enum class CloudForm { kImage, kBodyImage, kShuffled, kThreeViews };

struct CaseSensor {
  perception::SensorNoise noise = {};
  CloudForm form = CloudForm::kImage;
  bool matches_windows = false;  // see ScanOptions
};

// Scans a scene without interpreting it; the sensor's noise is drawn from the scene's seed.
SimulatedCase ScanCase(const CaseName& name, const CaseSensor& sensor = {});

// Interprets the scan on one thread with the sensor's noise given. The sensor's pose is given for
// even seeds; for odd ones neither pose nor up is, and up is estimated.
absl::Status InterpretCase(const CaseName& name, const CaseSensor& sensor,
                           const std::vector<std::string>& disabled_passes, SimulatedCase& scanned);

// Scans and interprets.
absl::StatusOr<SimulatedCase> RunCase(const CaseName& name, const CaseSensor& sensor = {});

}  // namespace cwm::benchmarks
