// Reading a URDF (the ROS wiki's `urdf/XML`) with the meshes that it names.
#pragma once

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>

#include "absl/status/statusor.h"
#include "collision/robot/robot_description.h"
#include "collision/robot/robot_limits.h"

namespace cwm::collision {

// Gives the bytes of a mesh file by the name that the URDF has for it ("package://...",
// "file://..." or a relative path). Asked once for each name. The message of an error is the rule
// alone, e.g. "must be one of the files sent along"; NOT_FOUND is made INVALID_ARGUMENT, other codes
// are kept.
using MeshSource = std::function<absl::StatusOr<std::string>(std::string_view uri)>;

// What is read, and how:
// - Of links their <collision> elements: box, cylinder, sphere, mesh, and as an extension
//   <capsule radius length>, the length between the centres as our Capsule has it.
// - A mesh's `scale` multiplies the vertices; one that mirrors turns the triangles round, so that
//   outside stays outside.
// - Joints of all six kinds. `rpy` turns about the fixed axes x, y, z in that order. An axis is
//   (1, 0, 0) where none is given, and made a unit; that of a fixed or floating joint is not read.
// - A revolute or prismatic joint must have a <limit>; its lower or upper is 0 where it is left
//   out. Those of other joints are not read, nor is the <mimic> of a fixed joint, which the Panda
//   has.
// - Everything else is passed over: visuals, inertias, transmissions, plugins, soft limits.
//
// Refuses, with INVALID_ARGUMENT that names the element, the value and the rule: malformed XML,
// unexpanded xacro, missing or unusable names, numbers and meshes, and what is no tree of links or
// leads mimics in circles. RESOURCE_EXHAUSTED likewise for what RobotLimits excludes. CANCELLED
// soon after `stop` was requested. Thread safe.
absl::StatusOr<RobotDescription> ReadUrdf(std::string_view xml, const MeshSource& meshes,
                                          const RobotLimits& limits = {},
                                          const std::stop_token& stop = {});

}  // namespace cwm::collision
