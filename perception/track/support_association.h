// Associates known supports with the supports of a scan.
#pragma once

#include <vector>

#include "perception/track/association.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// Returns one entry per support of the scene, and one per unmatched known support that the user
// does not own.
std::vector<Association> AssociateSupports(const std::vector<KnownObject>& known,
                                           const SceneInterpretation& scene,
                                           const ScanEvidence& scan);

}  // namespace cwm::perception
