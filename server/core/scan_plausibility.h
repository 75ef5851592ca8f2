// Judges whether a scan can show the world that it was associated with, so that a wrong unit or a
// wrong pose of the sensor does not replace what the world knows.
#pragma once

#include <optional>
#include <string>

#include "absl/status/status.h"
#include "perception/scene_interpretation.h"
#include "server/core/ingest_plan.h"

namespace cwm::server {

// Returns FailedPrecondition SCAN_CONTRADICTS_WORLD, with metadata "contradiction", for a scan that
// would change a world with objects of perception in one of these ways:
//   SCALE          half of its points lie where the sensor sees nothing
//   SUPPORTS_GONE  it removes supports and confirms none
//   MOVED_ALIKE    it moves three objects or more by one rigid motion of more than kMaxDrift_m, and
//                  keeps none in place
absl::Status CheckPlausible(const SceneMatch& match, const perception::SceneInterpretation& scene);

// The same, with VIEWPOINT, for a scan whose points were not seen from the origin of their frame, and
// that confirms none of the world's supports: its pose may not be the estimate of earlier scans.
absl::Status CheckConfirmsSupport(const SceneMatch& match);

// A warning for a motion as in MOVED_ALIKE that is smaller. Empty if there is none.
std::optional<std::string> DriftWarning(const SceneMatch& match);

// chosen: the mean displacement that calibrations of sensors lose in weeks; a greater one is a
// wrong pose.
inline constexpr double kMaxDrift_m = 0.03;

}  // namespace cwm::server
