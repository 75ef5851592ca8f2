// Changes of a world, for World::Apply and for overlays of queries.
//
// `expected_revision` is the object's revision as the writer knows it (Object::revision, for a
// robot state_revision): another one is kAborted, and nothing is changed.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/objects.h"
#include "cwm/robots.h"
#include "cwm/shapes.h"

namespace cwm::CWM_API {

// Adds the object, or replaces the one of that name.
struct Put {
  std::string name;
  Body body;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  double margin_m = 0;
  std::string supported_by = {};
  ObjectKind kind = ObjectKind::kUser;  // or kUnseen: space that no sensor has seen
  std::optional<std::int64_t> expected_revision = {};
};

struct Move {
  std::string name;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  std::optional<std::int64_t> expected_revision = {};
};

struct Remove {
  std::string name;
  std::optional<std::int64_t> expected_revision = {};
};

// Fixes the object to a link of a robot, as a gripper does: at X_LO, or where it is now.
struct Attach {
  std::string name;
  std::string robot;
  std::string link;
  std::optional<Eigen::Isometry3d> X_LO = {};
  std::vector<std::string> touch_links = {};
  std::optional<std::int64_t> expected_revision = {};
};

// Lets the object stand where it is.
struct Detach {
  std::string name;
  std::optional<std::int64_t> expected_revision = {};
};

// Lets the two collide, for so many seconds or for good; `withdraw` ends it. `check` checks a pair
// of links although the SRDF disables it.
struct Allow {
  NamedThing a;
  NamedThing b;
  std::optional<double> expires_after_s = {};
  bool withdraw = false;
  bool check = false;
};

// The margin of the pair in place of all others; absent: ends it.
struct Margin {
  NamedThing a;
  NamedThing b;
  std::optional<double> margin_m = {};
};

// The base and the joints of a robot; members that are not given keep their values.
struct SetState {
  std::string robot;
  JointState joints = {};
  std::optional<Eigen::Isometry3d> X_WB = {};
  std::optional<std::int64_t> expected_revision = {};
};

using Change = std::variant<Put, Move, Remove, Attach, Detach, Allow, Margin, SetState>;

}  // namespace cwm::CWM_API
