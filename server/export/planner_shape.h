// The shapes of MoveIt's planning scenes.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <variant>

#include "collision/geometry/shape.h"

namespace cwm::server {

// Centred at the origin with axis z; a cone has its apex at +z.
struct PlannerPrimitive {
  enum class Kind { kBox, kSphere, kCylinder, kCone };
  Kind kind = Kind::kBox;
  // Box: x y z. Sphere: radius. Cylinder and cone: length, radius, as shape_msgs/SolidPrimitive.
  std::array<double, 3> dimensions_m = {};
  int dimension_count = 0;
};

// The plane z = 0; its normal +z points out of the solid half-space.
struct PlannerPlane {};

using PlannerMesh = std::shared_ptr<const TriangleMesh>;

struct PlannerShape {
  Pose X_OS = Pose::Identity();
  std::variant<PlannerPrimitive, PlannerMesh, PlannerPlane> shape;
  std::string note;  // says how the shape was converted; empty if it is exact
};

// Converts a part's shape. Shapes that MoveIt has are written as such: a cone with an apex at
// either end, a truncated cone of equal radii as a cylinder, a rectangular plate without holes as a
// box, a half-space as a plane. Others become meshes: the exact mesh if they are one, otherwise a
// closed, inscribed mesh (tessellate.h).
PlannerShape ToPlannerShape(const Placed<Shape>& part);

}  // namespace cwm::server
