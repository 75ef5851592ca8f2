// The whole surface of an object as one mesh, on demand: for pictures, exports and grasp planners.
#pragma once

#include "collision/geometry/hybrid_model.h"

namespace cwm::perception {

// Everything that collision checking sees of the model, joined and in the object's frame: its
// shapes tessellated (Tessellate, to within `max_deviation_m`), hidden faces included, the meshes
// of its surfaces and of its handles. Parts that touch or overlap keep their own vertices: nothing
// is united or cut. Empty for a model without parts. Deterministic.
TriangleMesh FullSurface(const HybridModel& model, double max_deviation_m = 5e-4);

}  // namespace cwm::perception
