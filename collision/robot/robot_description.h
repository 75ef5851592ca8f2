// The content of a URDF: plain values in the order of the file. Lengths in metres, angles in
// radians. References are not resolved here, see robot_model.h.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collision/geometry/pose.h"
#include "collision/geometry/shape.h"

namespace cwm::collision {

// One <collision> of a link. Equal meshes of a robot share their triangles.
struct CollisionGeometry {
  std::string name;              // as in the file; often empty
  Pose X_LG = Pose::Identity();  // the shape in the link's frame
  Shape shape;                   // sphere, box, cylinder, capsule or mesh
};

// A link. Visuals and inertias are not kept.
struct Link {
  std::string name;
  std::vector<CollisionGeometry> collisions;
};

enum class JointKind { kFixed, kRevolute, kContinuous, kPrismatic, kPlanar, kFloating };

std::string_view NameOf(JointKind kind);  // as in a URDF: "fixed", "revolute" ...

// 0 for fixed; 1 for revolute, continuous and prismatic; 3 (x, y, theta) for planar; 7 (tx ty tz qx
// qy qz qw) for floating joints.
int VariableCount(JointKind kind);

// Limits of position in rad or m, of speed in rad/s or m/s, and of effort in Nm or N. The soft
// limits of a <safety_controller> are not kept, because they belong to a controller, not to the
// joint.
struct JointLimits {
  std::optional<double> lower;  // both or neither; revolute and prismatic joints have both
  std::optional<double> upper;
  std::optional<double> max_velocity;
  std::optional<double> max_effort;
};

// The value of the joint is multiplier * (value of the other joint) + offset.
struct Mimic {
  std::string joint;
  double multiplier = 1;
  double offset = 0;
};

// Connects the frames of two links: X_PC = X_PJ * motion(value), where the motion is about or along
// the axis, which is fixed in J (kinematics.h defines the motion of each kind).
struct Joint {
  std::string name;
  JointKind kind = JointKind::kFixed;
  std::string parent;
  std::string child;
  Pose X_PJ = Pose::Identity();
  Vector3 axis_J = Vector3::UnitX();  // unit; unused by fixed and floating joints
  JointLimits limits;
  std::optional<Mimic> mimic;  // for revolute, continuous and prismatic joints
};

struct RobotDescription {
  std::string name;
  std::vector<Link> links;
  std::vector<Joint> joints;
  std::vector<std::string> left_out;  // one line for each part of the file that has no effect
};

}  // namespace cwm::collision
