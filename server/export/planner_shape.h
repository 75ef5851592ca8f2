// Shapes as MoveIt's planning scenes know them.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <variant>

#include "collision/geometry/shape.h"

namespace cwm::server {

// Centred, axis z, the apex of a cone at +z.
struct PlannerPrimitive {
  enum class Kind { kBox, kSphere, kCylinder, kCone };
  Kind kind = Kind::kBox;
  // Box: x y z. Sphere: radius. Cylinder and cone: length, radius, as shape_msgs/SolidPrimitive.
  std::array<double, 3> dimensions_m = {};
  int dimension_count = 0;
};

// The plane z = 0, of which the normal +z points out of what is solid.
struct PlannerPlane {};

using PlannerMesh = std::shared_ptr<const TriangleMesh>;

struct PlannerShape {
  Pose X_OS = Pose::Identity();
  std::variant<PlannerPrimitive, PlannerMesh, PlannerPlane> shape;
  std::string note;  // what the shape became, where it is not said as it is; empty: it is
};

// A shape that MoveIt has is said as such: a cone that narrows to an apex at either end, a truncated
// one of equal radii as a cylinder, a rectangular plate without holes as a box, a half-space as a
// plane. Others become meshes: those they are, or inscribed ones (tessellate.h), closed.
PlannerShape ToPlanner(const Placed<Shape>& part);

}  // namespace cwm::server
