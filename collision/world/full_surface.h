// Everything that an object is made of as one mesh: for pictures, exports and whoever plans with
// meshes alone.
#pragma once

#include <cstddef>
#include <optional>

#include "collision/geometry/tessellate.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

struct FullSurface {
  TriangleMesh mesh_O;         // in the object's frame
  double max_deviation_m = 0;  // no point of the mesh is farther from the surface of its part
};

// A half-space among the parts has a surface without an end.
bool IsBounded(const PreparedModel& model);

// The parts of the model in their order, what collision checking sees: each tessellated, with
// vertices of its own, also where parts touch or overlap. Round parts deviate by at most
// kDefaultDeviation_m as far as Tessellate can (more for a large radius), and by more where that
// would make over `max_triangles`; nothing when the coarsest mesh is over it as well. Empty for a
// model without parts. `model` is bounded. Void where `work` ended it.
std::optional<FullSurface> FullSurfaceOf(const PreparedModel& model, std::size_t max_triangles,
                                         WorkCounter* work = nullptr);

}  // namespace cwm::collision
