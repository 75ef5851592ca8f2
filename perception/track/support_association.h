// Known supports against the supports of a scan.
#pragma once

#include <vector>

#include "perception/track/association.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// One entry per support of the scene, and one per known support that the user does not own and no
// support of the scene was matched with.
std::vector<Association> AssociateSupports(const std::vector<KnownObject>& known,
                                           const SceneInterpretation& scene,
                                           const ScanEvidence& scan);

}  // namespace cwm::perception
