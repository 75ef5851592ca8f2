// Which whole solids are offered at all.
#pragma once

#include "perception/whole/whole_fit.h"

namespace cwm::perception {

// Within the modeler's sizes, and as a thing of that kind stays: it does not tip or roll over.
bool IsValid(WholeKind kind, const WholeParameters& x, const ModelerOptions& options);

// A limit holds it back: what the points ask for is shorter still, and does not lie; or thinner
// still, and is a sheet, whose box would take up what lies between its points.
bool IsHeldBack(const WholeFit& fit, const ModelerOptions& options);

}  // namespace cwm::perception
