// The obstacles of a world in the form that the SIMD sphere checks use.
#pragma once

#include "collision/query/query.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// The obstacles that a robot with its root at X_WB can reach. `margin_m` is the margin of the
// query; its sum with the margin of any object is not negative.
LaneScene CompileScene(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double margin_m);

// True if the boxes of the robot's parts can reach an object with an open mesh. CompileScene
// replaces an open mesh by its box, so that its scene does not say which obstacles are open.
bool ReachesOpenMeshes(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double margin_m);

// True if those boxes can reach a hidden space, which no scene contains.
bool ReachesHiddenSpaces(const WorldSnapshot& world, const WorldFilter& filter,
                         const SphereProgram& program, const Pose& X_WB, double margin_m);

// The scene without obstacles, for self-collision checks.
LaneScene EmptyScene(const SphereProgram& program);

}  // namespace cwm::collision
