// Where a known object went, if a detection is that object at another place.
#pragma once

#include <optional>

#include "perception/track/object_evidence.h"

namespace cwm::perception {

struct Relocation {
  Pose X_LO = Pose::Identity();  // brings the known model onto the detected points
  PlacedFit fit;
};

// Nothing when the known model, wherever it is put, does not explain the detection.
std::optional<Relocation> Relocate(const ObjectEvidence& evidence, int k, int d,
                                   const ScanEvidence& scan);

}  // namespace cwm::perception
