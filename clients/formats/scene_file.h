// A MoveIt planning scene, as MotionBenchMaker and MoveIt write it in YAML.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"

namespace cwm::formats {

// Metres; the quaternion is of unit length.
struct ScenePose {
  std::array<double, 3> position_m = {0, 0, 0};
  std::array<double, 4> orientation_xyzw = {0, 0, 0, 1};
};

// Centred at the pose's origin, axis z, as shape_msgs/SolidPrimitive has them.
struct SceneBox {
  std::array<double, 3> size_m;
};
struct SceneSphere {
  double radius_m;
};
struct SceneCylinder {
  double height_m, radius_m;
};
struct SceneCone {  // the apex at +z
  double height_m, radius_m;
};

struct ScenePrimitive {
  ScenePose pose;  // in the object's frame
  std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCone> shape;
};

struct SceneObject {
  std::string id;
  ScenePose pose;                          // in the scene's fixed frame
  std::vector<ScenePrimitive> primitives;  // at least one
};

struct SceneFile {
  std::vector<SceneObject> objects;   // in the file's order, ids differ
  std::vector<std::string> warnings;  // what was left out, and why
};

// Reads world.collision_objects. Meshes and planes are left out with a warning, and objects without
// any primitive too. An orientation off unit length by at most 1 % is normalised. Anything else
// that does not fit is INVALID_ARGUMENT naming `file`, the field's path, its value and the rule.
absl::StatusOr<SceneFile> ParseScene(std::string_view yaml, const std::string& file);

}  // namespace cwm::formats
