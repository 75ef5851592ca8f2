// A query in the form that the SIMD sphere checks use: the spheres of a robot and of what it
// carries, the pairs of them that must not touch, and the obstacles.
#pragma once

#include <memory>
#include <optional>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"
#include "collision/spheres/sphere_lanes.h"
#include "collision/spheres/sphere_program.h"

namespace cwm::collision {

// Tags of worlds are frames of the body, tags of pairs are indices of FramePairsOf(body), both
// modulo kTags. Immutable.
struct SphereQuery {
  std::shared_ptr<const SphereProgram> program;
  LaneScene scene;
  // True if the robot is made of spheres, so that contact can be proven, not only gaps.
  bool proves_contact = false;
  // The frames and pairs that determine the accuracy of a free state. Spheres prove parts apart,
  // but do not show if the boxes of parts meet those of an open mesh.
  UnresolvedTags tags_for_accuracy = {};
};

// Empty if the query is not suited: shapes without spheres around them, too few rows of them
// (`row_count`), FCL or Bullet chosen by name, joints that the SIMD kinematics do not support,
// links that can leave the coordinates of a world, margin_sigma > 0.
std::optional<SphereQuery> CompileQuery(const WorldSnapshot& world, const QueryBody& body,
                                        const JointRows& rows, std::size_t row_count,
                                        const QueryOptions& options);

}  // namespace cwm::collision
