// Small robots as URDF text.
#pragma once

#include <string>

#include "collision/robot/urdf.h"

namespace cwm::collision::testing {

inline std::string Robot(const std::string& elements) {
  return "<?xml version=\"1.0\"?>\n<robot name=\"r\">\n" + elements + "</robot>\n";
}

inline std::string Links(const std::string& names) {  // one letter each
  std::string text;
  for (const char name : names) text += std::string("<link name=\"") + name + "\"/>\n";
  return text;
}

// A link with a ball of 0.1 m radius.
inline std::string Ball(const std::string& name) {
  return "<link name=\"" + name +
         "\"><collision><geometry><sphere radius=\"0.1\"/></geometry></collision></link>\n";
}

inline std::string JointText(const std::string& name, const std::string& kind,
                             const std::string& parent, const std::string& child,
                             const std::string& more = "<limit lower=\"-1\" upper=\"1\"/>") {
  return "<joint name=\"" + name + "\" type=\"" + kind + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + more + "</joint>\n";
}

// Three balls of 0.1 m radius, 0.5 m apart along x: one is fixed, one turns about the first's z
// axis, and one turns about the second's z axis. If the last joint bends by more than 156 degrees,
// the last ball meets the first.
inline std::string ThreeBalls() {
  const std::string arm = "<origin xyz=\"0.5 0 0\"/>";
  const std::string limits = "<axis xyz=\"0 0 1\"/><limit lower=\"-3\" upper=\"3\"/>";
  return Ball("a") + Links("bd") + Ball("c") + Ball("e") +
         JointText("shoulder", "revolute", "a", "b", limits) +
         JointText("upper", "fixed", "b", "c", arm) +
         JointText("elbow", "revolute", "c", "d", limits) +
         JointText("lower", "fixed", "d", "e", arm);
}

// A mesh source for robots without meshes.
inline absl::StatusOr<std::string> NoMeshes(std::string_view) {
  return absl::NotFoundError("must be one of the files sent along");
}

}  // namespace cwm::collision::testing
