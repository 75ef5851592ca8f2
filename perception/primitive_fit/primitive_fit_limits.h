// Limits that every fitted solid must keep.
#pragma once

#include "perception/primitive_fit/primitive_fit.h"

namespace cwm::perception {

// True if the sizes are within the options' limits and the solid is stable: it neither tips nor
// rolls over.
bool IsValid(PrimitiveKind kind, const PrimitiveParameters& x, const ModelerOptions& options);

// True if a limit kept the fit from becoming smaller. The points then ask for something that would
// not stay lying, or for a sheet, whose box would fill the space between the points.
bool IsAtLimit(const PrimitiveFit& fit, const ModelerOptions& options);

}  // namespace cwm::perception
