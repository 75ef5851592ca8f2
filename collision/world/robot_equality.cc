// Equality of robots, declared in model_equality.h.
#include <algorithm>

#include "collision/world/model_equality.h"

namespace cwm::collision {
namespace {

bool Same(const CollisionGeometry& a, const CollisionGeometry& b) {
  return a.name == b.name && SamePose(a.X_LG, b.X_LG) && a.shape == b.shape;
}

bool Same(const Variable& a, const Variable& b) {
  return a.name == b.name && a.link == b.link && a.component == b.component && a.lower == b.lower &&
         a.upper == b.upper;
}

bool Same(const NamedState& a, const NamedState& b) {
  return a.name == b.name && a.variables == b.variables && a.values == b.values;
}

bool Same(const LinkSphere& a, const LinkSphere& b) {
  return a.center_L == b.center_L && a.radius_m == b.radius_m;
}

bool Same(const ModelLink& a, const ModelLink& b);
bool Same(const JointGroup& a, const JointGroup& b);
bool Same(const RobotTool& a, const RobotTool& b);

template <class T>
bool Same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const T& x, const T& y) { return Same(x, y); });
}

bool SameJoint(const ModelLink& a, const ModelLink& b) {
  return a.joint == b.joint && a.kind == b.kind && SamePose(a.X_PJ, b.X_PJ) &&
         a.axis_J == b.axis_J && a.variable == b.variable && a.is_mimic == b.is_mimic &&
         a.multiplier == b.multiplier && a.offset == b.offset;
}

bool Same(const ModelLink& a, const ModelLink& b) {
  return a.name == b.name && a.urdf_index == b.urdf_index && a.parent == b.parent &&
         a.body == b.body && a.padding_m == b.padding_m && a.scale == b.scale && SameJoint(a, b) &&
         Same(a.collisions, b.collisions);
}

bool Same(const RobotTool& a, const RobotTool& b) {
  return a.name == b.name && a.link == b.link && SamePose(a.X_LT, b.X_LT) && a.group == b.group;
}

bool Same(const JointGroup& a, const JointGroup& b) {
  return a.name == b.name && a.variables == b.variables && a.joints == b.joints &&
         a.moved_links == b.moved_links && a.tool_link == b.tool_link && Same(a.states, b.states);
}

bool Same(const RobotModel& a, const RobotModel& b) {
  return a.name == b.name && Same(a.links, b.links) && Same(a.variables, b.variables) &&
         Same(a.groups, b.groups) && Same(a.tools, b.tools) && a.self_pairs == b.self_pairs &&
         a.left_out == b.left_out;
}

}  // namespace

bool SameRobot(const RobotGeometry& a, const RobotGeometry& b) {
  if (&a == &b) return true;
  if (a.spheres_as_given.has_value() != b.spheres_as_given.has_value()) return false;
  const bool same_spheres =
      !a.spheres_as_given.has_value() || Same(a.spheres_as_given->links, b.spheres_as_given->links);
  return same_spheres && Same(*a.model, *b.model);
}

}  // namespace cwm::collision
