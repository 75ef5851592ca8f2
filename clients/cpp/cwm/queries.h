// Queries: the subject, its rows and the options.
#pragma once

#include <Eigen/Geometry>
#include <concepts>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "cwm/changes.h"
#include "cwm/namespace.h"
#include "cwm/robots.h"
#include "cwm/shapes.h"

namespace cwm::CWM_API {

// The obstacles that a robot is checked against.
enum class RobotScope { kWorld = 1, kSelf, kBoth };
// The geometry that represents the links of the robot. kSpheresContaining proves states
// free; kSpheresAsGiven says nothing certain about the links.
enum class RobotGeometry { kExact = 1, kSpheresContaining, kSpheresAsGiven };

// A robot of the world. It is left out of the world, and so is what it carries.
struct RobotSubject {
  std::string robot;
  std::string group = {};  // of the SRDF; empty: all variables of the robot
  RobotScope scope = RobotScope::kBoth;
  RobotGeometry geometry = RobotGeometry::kExact;
  std::optional<Eigen::Isometry3d> X_WB = {};  // absent: where the robot is
  JointState base_state = {};                  // joints outside the group
  // In place of those with which the robot was loaded.
  std::vector<LinkPadding> link_padding = {};
};

// Points in columns, metres, in the world.
struct Points {
  Eigen::Matrix3Xd points;
};

// The subject of a query: a body (a shape or several), an object of the world by its name, which is
// left out of the world, a robot, or points.
class Subject {
 public:
  template <class T>
  requires(std::convertible_to<T, Body> && !std::same_as<T, Subject>) Subject(T body)
      : what_(Body(std::move(body))) {}                                  // NOLINT: implicit
  Subject(RobotSubject robot) : what_(std::move(robot)) {}               // NOLINT: implicit
  Subject(Points points) : what_(std::move(points)) {}                   // NOLINT: implicit
  Subject(std::string object_name) : what_(std::move(object_name)) {}    // NOLINT: implicit
  Subject(const char* object_name) : what_(std::string(object_name)) {}  // NOLINT: implicit

  const std::variant<Body, std::string, RobotSubject, Points>& what() const { return what_; }

 private:
  std::variant<Body, std::string, RobotSubject, Points> what_;
};

// The rows of a query: states of a robot, in columns of dof x N, or poses X_WB of a body or an
// object. A single state is a vector, a single pose an Isometry3d. Without rows a robot and an
// object are where they are, and a body is at the world's origin; points have none.
//
// Poses are referred to, so Rows must not outlive them.
class Rows {
 public:
  Rows() = default;
  template <class T>
  requires std::convertible_to<const T&, std::span<const Eigen::Isometry3d>> Rows(const T& poses)
      : rows_(std::span<const Eigen::Isometry3d>(poses)) {}  // NOLINT: implicit
  Rows(const Eigen::Isometry3d& pose)                        // NOLINT: implicit
      : rows_(std::span<const Eigen::Isometry3d>(&pose, 1)) {}
  template <class Derived>
  Rows(const Eigen::MatrixBase<Derived>& states) : rows_(Eigen::MatrixXd(states)) {}  // NOLINT
  // One state, as of std::vector<double>.
  Rows(std::span<const double> state)  // NOLINT: implicit
      : rows_(Eigen::MatrixXd(Eigen::Map<const Eigen::VectorXd>(
            state.data(), static_cast<Eigen::Index>(state.size())))) {}
  Rows(const std::vector<double>& state)  // NOLINT: implicit
      : Rows(std::span<const double>(state)) {}

  const std::variant<std::monostate, std::span<const Eigen::Isometry3d>, Eigen::MatrixXd>& what()
      const {
    return rows_;
  }

 private:
  std::variant<std::monostate, std::span<const Eigen::Isometry3d>, Eigen::MatrixXd> rows_;
};

enum class Engine { kAuto = 1, kExact, kFcl, kBullet };
// The parts of objects that count.
enum class Representation { kShapes = 1, kSurfaces, kHybrid };
// The meaning of space that no sensor has seen: nothing, undecided, or an obstacle.
enum class UnseenSpace { kIgnore = 1, kReport, kBlock };
// The pairs that Distance answers for: the nearest objects, or each link of the subject with each
// object, each link of other robots, and each own link that it is checked against.
enum class DistancePairs { kObjects = 1, kLinks };

struct QueryOptions {
  // The margin of verdicts, motions and contacts: a smaller distance is a collision. Distances are
  // geometric.
  double margin_m = 0;
  std::optional<double> max_distance_m = {};  // how far to look; absent: no limit
  // Distance: nearest objects of a row, or of each link with kLinks; 1 to 64. 0: 1; with kLinks all
  // within max_distance_m.
  int max_results = 0;
  DistancePairs pairs = DistancePairs::kObjects;  // Distance
  bool joint_gradient = false;                    // Distance of a robot: PairResult::joint_gradient
  int max_contacts = 0;                           // Contacts: points of a row, 1 to 1 024; 0: 16
  int max_contacts_per_pair = 0;  // Contacts: points of each pair; 0: all, at most 5
  bool verdicts_only = false;     // Check: names no pair, which is faster
  // Only pairs of these objects, robots, or links: links of the subject restrict its body, others
  // what it is tested against. Empty: all.
  std::vector<NamedThing> only = {};
  std::vector<std::string> ignore = {};                              // objects and robots left out
  std::vector<std::pair<NamedThing, NamedThing>> ignore_pairs = {};  // pairs that may collide
  std::vector<Change> overlay = {};  // changes that hold for this query alone, see WhatIf
  Engine engine = Engine::kAuto;
  Representation representation = Representation::kHybrid;
  UnseenSpace unseen = UnseenSpace::kBlock;
  double margin_sigma = 0;  // inflates fitted parts by so many standard deviations
  // How deep what stands may sink into its support; absent: 0.005.
  std::optional<double> support_tolerance_m = {};
  std::optional<double> time_budget_s = {};  // the rows answered by then are the answer
};

// Inverse kinematics. The tool T is fixed to a link L of the robot.
struct SolveOptions {
  // The name of a tool of the robot, in place of the next two.
  std::string tool = {};
  std::string tool_link = {};                  // empty: the link that the SRDF names for the group
  std::optional<Eigen::Isometry3d> X_LT = {};  // absent: identity
  // Seeds of the search: one state for all poses, or one for each; none: the present state.
  Rows seeds = {};
  int max_solutions = 1;  // of each pose, at most 64, distinct by more than 0.1 rad or m
  double position_tolerance_m = 1e-6;
  double rotation_tolerance_rad = 1e-6;
  bool avoid_collision = false;  // leaves out what Check does not call free with `query`
  bool same_branch = false;      // searches from the seed alone
  int max_steps = 0;             // of the search for one pose; 0: 2000
  QueryOptions query = {};
};

}  // namespace cwm::CWM_API
