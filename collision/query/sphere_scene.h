// The obstacles of a world in the form that the SIMD sphere checks use.
#pragma once

#include <functional>

#include "collision/query/query.h"
#include "collision/query/world_filter.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// The terms between the spheres of a class (PlacedSphere::scene_class) and a part of an obstacle.
struct LaneTerms {
  bool is_tested = true;
  bool proves_gap_only = false;  // contact, nearer than the margin, is not that of the query
  double margin_m = 0;           // >= 0
};
using LaneTermsOf =
    std::function<LaneTerms(int scene_class, const Obstacle& object, std::size_t part)>;

// The obstacles that a robot with its root at X_WB can reach. No margin exceeds `max_margin_m`.
LaneScene CompileScene(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double max_margin_m,
                       const LaneTermsOf& terms);

// True if the boxes of the robot's parts can reach an object with an open mesh. CompileScene
// replaces an open mesh by its box, so that its scene does not say which obstacles are open.
bool ReachesOpenMeshes(const WorldSnapshot& world, const WorldFilter& filter,
                       const SphereProgram& program, const Pose& X_WB, double max_margin_m);

// True if those boxes can reach a hidden space, which no scene contains.
bool ReachesHiddenSpaces(const WorldSnapshot& world, const WorldFilter& filter,
                         const SphereProgram& program, const Pose& X_WB, double max_margin_m);

// The scene without obstacles, for self-collision checks.
LaneScene EmptyScene(const SphereProgram& program);

}  // namespace cwm::collision
