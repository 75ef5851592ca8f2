#include "collision/robot/robot_description.h"

namespace cwm::collision {

std::string_view NameOf(JointKind kind) {
  switch (kind) {
    case JointKind::kFixed:
      return "fixed";
    case JointKind::kRevolute:
      return "revolute";
    case JointKind::kContinuous:
      return "continuous";
    case JointKind::kPrismatic:
      return "prismatic";
    case JointKind::kPlanar:
      return "planar";
    case JointKind::kFloating:
      return "floating";
  }
  return "unknown";
}

int VariableCount(JointKind kind) {
  switch (kind) {
    case JointKind::kFixed:
      return 0;
    case JointKind::kRevolute:
    case JointKind::kContinuous:
    case JointKind::kPrismatic:
      return 1;
    case JointKind::kPlanar:
      return 3;
    case JointKind::kFloating:
      return 7;
  }
  return 0;
}

}  // namespace cwm::collision
