// Reads a URDF (the ROS wiki's `urdf/XML`) with the meshes that it refers to.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/robot/link_values.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// Returns the bytes of a mesh file, by its name in the URDF ("package://...", "file://..." or a
// relative path). Called once for each name. The message of an error is the rule alone, e.g. "must
// be one of the files sent along". NOT_FOUND becomes INVALID_ARGUMENT; other codes are kept.
using MeshSource = std::function<absl::StatusOr<std::string>(std::string_view uri)>;

// Reads a URDF:
// - The <collision> elements of links: box, cylinder, sphere, mesh, and as an extension <capsule
//   radius length>, whose length is that between the centres, as in Capsule.
// - The `scale` of a mesh multiplies its vertices. A mirroring scale reverses the order of the
//   corners, so that the outside stays outside.
// - Joints of all six kinds. `rpy` rotates about the fixed axes x, y, z in that order. The axis is
//   (1, 0, 0) by default, and normalised; the axis of a fixed or floating joint is not read.
// - A revolute or prismatic joint must have a <limit>, whose lower and upper are 0 by default. The
//   lower and upper of other joints are not read, nor is the <mimic> of a fixed joint, which the
//   Panda has.
// - Everything else is ignored: visuals, inertias, transmissions, plugins, soft limits.
//
// Refuses, with INVALID_ARGUMENT that names the element, the value and the rule: malformed XML,
// unexpanded xacro, missing or unusable names, numbers and meshes, links that do not form a tree,
// and mimics in a cycle. RESOURCE_EXHAUSTED for files that exceed RobotLimits. CANCELLED soon after
// `stop` was requested. Thread safe.
//
// The collision geometry of a link is scaled by its value in `scale` about the geometry's own
// origin: its size changes, its pose does not. The rules for shapes hold for the scaled ones.
absl::StatusOr<RobotDescription> ReadUrdf(std::string_view xml, const MeshSource& meshes,
                                          const RobotLimits& limits = {},
                                          const std::stop_token& stop = {},
                                          const LinkValues& scale = {});

}  // namespace cwm::collision
