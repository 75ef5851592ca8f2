// Finds the new pose of a known object, if a detection is that object at another place.
#pragma once

#include <optional>

#include "perception/track/object_evidence.h"

namespace cwm::perception {

struct Relocation {
  Pose X_LO = Pose::Identity();  // brings the known model onto the detected points
  PlacedFit fit;
};

// Empty if the known model does not explain the detection at any tried pose.
std::optional<Relocation> Relocate(const ObjectEvidence& evidence, int k, int d,
                                   const ScanEvidence& scan);

}  // namespace cwm::perception
