// A MoveIt planning scene as MoveIt, MotionBenchMaker and related tools write it: in YAML
// (moveit_msgs/PlanningScene) or as text (".scene", objects only).
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/mesh_file.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// Primitives are centred at the pose's origin with axis z, as in shape_msgs/SolidPrimitive.
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
// Solid where z <= 0, the side opposite to the normal of the file's plane.
struct SceneHalfSpace {};

struct SceneShape {
  ScenePose pose;  // in the object's frame
  std::variant<SceneBox, SceneSphere, SceneCylinder, SceneCone, SceneHalfSpace, MeshFile> shape;
};

struct SceneObject {
  std::string id;
  ScenePose pose;                  // in the scene's fixed frame
  std::vector<SceneShape> shapes;  // primitives, meshes, planes
};

struct SceneJoint {
  std::string name;
  double position = 0;  // rad or m
};
struct SceneMultiDofJoint {
  std::string name;
  ScenePose transform;
};

struct SceneAttachedObject {
  SceneObject object;  // without shapes: an object of the scene with that id
  std::string link;
  bool pose_is_in_link = false;  // true if object.pose is in the link's frame
  std::vector<std::string> touch_links;
};

struct SceneRobotState {
  std::vector<SceneJoint> joints;
  // Floating and planar joints, including the virtual joint that connects the robot to the world.
  std::vector<SceneMultiDofJoint> multi_dof_joints;
  std::vector<SceneAttachedObject> attached;
  bool empty() const { return joints.empty() && multi_dof_joints.empty(); }
};

// The pairs of links and objects that may collide, by name. A pair that is not in the matrix has
// its default; if both names have one, both must allow it.
struct SceneAllowedCollisions {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;  // square, one row per name
  std::vector<std::pair<std::string, bool>> defaults;
};

struct SceneFile {
  std::string robot_model_name;      // empty: not given
  std::vector<SceneObject> objects;  // in the file's order, with distinct ids
  // True if the file has only differences from a previous scene; such a file may remove objects.
  bool is_diff = false;
  std::vector<std::string> removed;  // ids that no object has
  SceneRobotState robot_state;
  SceneAllowedCollisions allowed_collisions;
  std::vector<std::string> warnings;  // what was ignored, and why
};

struct SceneOptions {
  // A frame that equals the world's, besides "", "world" and the frames that the file fixes there.
  std::string world_frame = {};
};

// Reads either format, distinguished by the second line. Orientations up to 1 % off unit length are
// normalised; triangles that use a vertex twice are dropped. Octomaps, padding and scale are
// ignored with a warning; colours, types and subframes, which do not affect collisions, without
// one. Other errors are INVALID_ARGUMENT with `file`, the field's path or line, its value and the
// rule.
absl::StatusOr<SceneFile> ParseScene(std::string_view bytes, const std::string& file,
                                     const SceneOptions& options = {});

// derived: the server's limit of coordinates and dimensions, in magnitude (metres).
inline constexpr double kMaxSceneNumber = 1e6;

}  // namespace cwm::formats
