// A MoveIt planning scene, as MoveIt, MotionBenchMaker and tools around them write it: in YAML
// (moveit_msgs/PlanningScene) or as text (".scene", objects alone).
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
// Solid where z <= 0: the side that the normal of a file's plane points away from.
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
  SceneObject object;  // without shapes: one that the scene has by that id
  std::string link;
  bool pose_is_in_link = false;  // object.pose is in the frame of the link
  std::vector<std::string> touch_links;
};

struct SceneRobotState {
  std::vector<SceneJoint> joints;
  // Floating and planar joints, among them the virtual joint by which the robot stands there.
  std::vector<SceneMultiDofJoint> multi_dof_joints;
  std::vector<SceneAttachedObject> attached;
  bool empty() const { return joints.empty() && multi_dof_joints.empty(); }
};

// Which pairs may collide. Of links and objects by name; what is in no pair of the matrix has the
// value of its default, of two with defaults both must allow it.
struct SceneAllowedCollisions {
  std::vector<std::string> names;
  std::vector<std::vector<bool>> allowed;  // square, one row a name
  std::vector<std::pair<std::string, bool>> defaults;
};

struct SceneFile {
  std::string robot_model_name;      // empty: not said
  std::vector<SceneObject> objects;  // in the file's order, ids differ
  // Whether it only says what differs from the scene of before; such a one may take objects away.
  bool is_diff = false;
  std::vector<std::string> removed;  // ids, none of which is of an object
  SceneRobotState robot_state;
  SceneAllowedCollisions allowed_collisions;
  std::vector<std::string> warnings;  // what was left out, and why
};

struct SceneOptions {
  // A frame that is the world's, besides "", "world" and the frames that the file fixes there.
  std::string world_frame = {};
};

// Reads either format, told apart by the second line. An orientation off unit length by at most 1 %
// is normalised; triangles that use a vertex twice are left out. What collision checking cannot use
// (octomaps, padding, scale) is left out with a warning; colours, types and subframes, which say
// nothing about collisions, without one. Anything else that does not fit is INVALID_ARGUMENT naming
// `file`, the field's path or line, its value and the rule.
absl::StatusOr<SceneFile> ParseScene(std::string_view bytes, const std::string& file,
                                     const SceneOptions& options = {});

// The largest coordinate or dimension, in magnitude: the server takes no larger ones (metres).
inline constexpr double kLargestSceneNumber = 1e6;

}  // namespace cwm::formats
