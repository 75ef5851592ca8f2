// A robot as its URDF says: plain values in the order of the file. Lengths in metres, angles in
// radians; nothing is resolved here, see robot_model.h.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/geometry/shape.h"

namespace cwm::collision {

// One <collision> of a link. Equal meshes of a robot are shared.
struct CollisionGeometry {
  std::string name;              // as the element says; often empty
  Pose X_LG = Pose::Identity();  // the shape in the link's frame
  Shape shape;                   // sphere, box, cylinder, capsule or mesh
};

// Visuals and inertias are not kept.
struct Link {
  std::string name;
  std::vector<CollisionGeometry> collisions;
};

enum class JointKind { kFixed, kRevolute, kContinuous, kPrismatic, kPlanar, kFloating };

std::string_view NameOf(JointKind kind);  // as in a URDF: "fixed", "revolute" ...

// Fixed 0; revolute, continuous, prismatic 1; planar 3 (x, y, theta); floating 7 (tx ty tz qx qy qz
// qw).
int VariableCount(JointKind kind);

// Of position in rad or m; of speed and effort per second, and in Nm or N. Soft limits of a
// <safety_controller> are not kept: they are a controller's, not the joint's.
struct JointLimits {
  std::optional<double> lower;  // both or neither; revolute and prismatic joints have both
  std::optional<double> upper;
  std::optional<double> max_velocity;
  std::optional<double> max_effort;
};

// The value is multiplier * (value of the other joint) + offset.
struct Mimic {
  std::string joint;
  double multiplier = 1;
  double offset = 0;
};

// Joins the frames of two links: X_PC = X_PJ * motion(value), where the motion is about or along
// the axis, which is fixed in J (kinematics.h tells the motion of each kind).
struct Joint {
  std::string name;
  JointKind kind = JointKind::kFixed;
  std::string parent;
  std::string child;
  Pose X_PJ = Pose::Identity();
  Vector3 axis_J = Vector3::UnitX();  // unit; of no meaning for fixed and floating joints
  JointLimits limits;
  std::optional<Mimic> mimic;  // of revolute, continuous and prismatic joints alone
};

struct RobotDescription {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
};

}  // namespace cwm::collision
