// Known objects and residual geometry against those of a scan.
#pragma once

#include <vector>

#include "perception/track/association.h"
#include "perception/track/scan_evidence.h"

namespace cwm::perception {

// One entry per object of the scene, and one per known object or residual that the user does not
// own and no object of the scene was matched with.
std::vector<Association> AssociateObjects(const std::vector<KnownObject>& known,
                                          const SceneInterpretation& scene,
                                          const ScanEvidence& scan);

}  // namespace cwm::perception
