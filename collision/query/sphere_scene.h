// The world as lanes know it.
#pragma once

#include "collision/query/query.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// What of the world a robot whose root stands at X_WB can reach. `margin_m` is that of the
// question: it and those of all objects together are not negative.
LaneScene CompileScene(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double margin_m);

// Whether there are open meshes in the world where boxes around the robot's parts may get: CompileScene
// takes them for the boxes around them, and tells them from nothing else.
bool MeetsOpenMeshes(const WorldSnapshot& world, const WorldFilter& filter,
                     const SphereProgram& program, const Pose& X_WB, double margin_m);

// For a robot that is asked about itself alone.
LaneScene EmptyScene(const SphereProgram& program);

}  // namespace cwm::collision
