// Robots of a world as values. Joint values are rad or m.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/shapes.h"

namespace cwm::CWM_API {

enum class JointKind {
  kNone = 0,  // of the root link
  kFixed,
  kRevolute,
  kContinuous,
  kPrismatic,
  kPlanar,
  kFloating
};

// An extra margin of a link against the world, and not against the robot itself. "*": each link
// that is not named.
struct LinkPadding {
  std::string link;
  double padding_m = 0;
};

// Scales the collision geometry of a link about the origin of each geometry, 0.01 to 100.
struct LinkScale {
  std::string link;
  double scale = 1;
};

// A link and the joint that connects it to its parent.
struct Link {
  std::string name;
  std::string parent;  // empty for the root
  std::string joint;
  JointKind joint_kind = JointKind::kNone;
  std::string follows;  // the joint that this joint mimics; empty: none
  int collision_count = 0;
  std::int64_t triangle_count = 0;
  int sphere_count = 0;
  std::vector<int> unchecked_links = {};  // indices of later links that are not checked against it
  double padding_m = 0;
  double scale = 1;
};

// One number of a state.
struct Variable {
  std::string name;
  std::string joint;
  JointKind joint_kind = JointKind::kNone;
  std::optional<double> lower = {};  // absent: no limit
  std::optional<double> upper = {};
};

// Joints of the SRDF: a row of a query has the values of their variables, in this order.
struct Group {
  std::string name;
  std::vector<std::string> joints = {};
  std::map<std::string, std::map<std::string, double>> states = {};  // values by variable
};

// A frame in which a tool acts, fixed to a link L.
struct Tool {
  std::string name;
  std::string link;
  Eigen::Isometry3d X_LT = Eigen::Isometry3d::Identity();
  std::string group = {};  // that moves the tool and uses it by default; empty: none
};

// A robot of a world. X_WB is the pose of its root link.
struct Robot {
  std::string name;
  std::string uid;
  std::vector<Link> links = {};  // parents first
  std::vector<Variable> variables = {};
  std::vector<Group> groups = {};
  std::vector<Tool> tools = {};
  std::int64_t self_pair_count = 0;
  Eigen::Isometry3d X_WB = Eigen::Isometry3d::Identity();
  Eigen::VectorXd state = {};  // one value per variable
  std::int64_t create_revision = 0;
  std::int64_t state_revision = 0;

  // Errors with kNotFound name the groups that there are.
  const Group& group(const std::string& name) const;
  // The variables of a row of the group, in its order; "": all.
  std::vector<Variable> VariablesOf(const std::string& group = {}) const;
  // dof x 2: the lower and the upper limit of each value of a row; infinite if there is none.
  Eigen::MatrixX2d Limits(const std::string& group = {}) const;
  // (dof): the present values of the group, or those of a named state where it has them.
  Eigen::VectorXd Row(const std::string& group = {}, const std::string& named_state = {}) const;
};

// A state that the SRDF names.
struct NamedState {
  std::string group;
  std::string state;
};

// Values that joints shall have; the others stay as they are.
struct JointState {
  std::optional<NamedState> named = {};       // applied first
  std::map<std::string, double> values = {};  // by variable
};

// The files of a robot: each a path, or the text itself if it begins with "<".
struct RobotFiles {
  std::string urdf;
  std::string srdf = {};     // empty: no groups, and neighbours alone are not checked
  std::string spheres = {};  // a "spherized" URDF of the same links; empty: no sphere model
  // Folders that hold packages of package:// URIs, or are one by their name or their package.xml.
  // Empty: the folder of the URDF and the three above it.
  std::vector<std::string> package_folders = {};
};

struct LoadOptions {
  std::string name = {};  // empty: that of the URDF
  std::optional<Eigen::Isometry3d> X_WB = {};
  JointState initial_state = {};
  std::vector<LinkPadding> link_padding = {};
  std::vector<LinkScale> link_scale = {};
  std::vector<Tool> tools = {};
};

struct LoadedRobot {
  Robot robot;
  std::vector<std::string> warnings = {};  // about the files, such as which meshes are open
};

}  // namespace cwm::CWM_API
