// Associates known objects and residual geometry with those of a scan.
#pragma once

#include <vector>

#include "perception/track/association.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// Returns one entry per object of the scene, and one per unmatched known object or residual that
// the user does not own.
std::vector<Association> AssociateObjects(const std::vector<KnownObject>& known,
                                          const SceneInterpretation& scene,
                                          const ScanEvidence& scan);

}  // namespace cwm::perception
