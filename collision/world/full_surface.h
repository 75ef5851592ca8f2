// All parts of an object as one mesh, for pictures, exports and planners that take only meshes.
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

// False if a part is a half-space, whose surface is infinite.
bool IsBounded(const PreparedModel& model);

// Joins the parts of a bounded model in order, as collision checking uses them. Each part is
// tessellated with vertices of its own, even where parts touch or overlap. Round parts deviate by
// at most kDefaultDeviation_m if Tessellate can achieve that (by more for a large radius), and by
// more if there would otherwise be more than `max_triangles`. Empty if even the coarsest mesh has
// more. The mesh is empty for a model without parts, and void if `work` stopped the function.
std::optional<FullSurface> FullSurfaceOf(const PreparedModel& model, std::size_t max_triangles,
                                         WorkCounter* work = nullptr);

}  // namespace cwm::collision
