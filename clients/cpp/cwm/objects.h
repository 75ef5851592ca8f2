// Objects of a world as values. X_AB is the pose of frame B in frame A: W is the world, O the
// object, S a shape. Metres.
#pragma once

#include <Eigen/Geometry>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/shapes.h"

namespace cwm::CWM_API {

// kMover: a piece of something that moves and is not modelled, e.g. a hand.
enum class ObjectKind { kSupport = 1, kObject, kResidual, kUnseen, kUser, kMover };
enum class Owner { kPerception = 1, kUser };
enum class ObjectState { kUnknown = 0, kConfirmed, kOccluded, kLost };
// The motion and the visibility of an object, as running sensors tell; kNotFollowed: none does. An
// object at rest has a pose that is constant to the bit. kStale is out of view or without a return,
// kLost was followed while it moved and not seen since.
enum class Motion { kNotFollowed = 0, kAtRest, kMoving, kSettling };
enum class Visibility { kNotFollowed = 0, kVisible, kOccluded, kStale, kLost };
// kCompleted was supplied where nothing was measured, at least in part.
enum class PartRole { kFitted = 1, kCompleted };
// How much of an object is told: kBasic without shapes, kFull with surfaces and handles.
enum class ObjectView { kBasic = 1, kShapes, kFull };

using Time = std::chrono::system_clock::time_point;

struct OrientedBox {
  Box size = {};
  Eigen::Isometry3d X_OB = Eigen::Isometry3d::Identity();  // the centre and the axes
};

// How well a fitted shape explains its points.
struct FitQuality {
  double rms_m = 0;
  double max_residual_m = 0;
  std::int64_t inlier_count = 0;
  double inlier_ratio = 0;
  double observed_fraction = 0;
  // One standard deviation of each coefficient, in their order; for a box, of its three sizes.
  // Empty: unknown.
  std::vector<double> parameter_sigma = {};
};

// An open vessel: a solid of revolution about z with a wall, a rim and a floor, the foot at
// z = -height/2. Profiles have the distance from the axis and z in columns, up the outside and
// down the inside.
struct Vessel {
  double rim_radius_m = 0;   // of the outside
  double foot_radius_m = 0;  // of the outside
  double height_m = 0;
  double depth_m = 0;  // from the rim to the floor inside
  double wall_thickness_m = 0;
  std::optional<double> rim_radius_sigma_m = {};
  std::optional<double> wall_thickness_sigma_m = {};
  Polygon outer_profile = {};
  Polygon inner_profile = {};
};

// A shape of an object.
struct Part {
  Shape shape = {};
  Eigen::Isometry3d X_OS = Eigen::Isometry3d::Identity();
  PartRole role = PartRole::kFitted;
  // The model of PCL in the object's frame: plane nx ny nz d; sphere c r; cylinder q a r; cone apex
  // a half_angle (rad). Empty if PCL has no such model.
  std::vector<double> coefficients = {};
  std::optional<FitQuality> fit = {};  // absent: a user gave the shape
  std::optional<Vessel> vessel = {};   // of which the shape is the mesh
  // Space that no sensor saw and into which the part may extend.
  std::optional<OrientedBox> hidden = {};
};

// A measured mesh of an object; WorldView::ReadMesh reads its triangles by the hash.
struct Surface {
  std::string hash;
  std::int64_t vertex_count = 0;
  std::int64_t triangle_count = 0;
  bool watertight = false;
  std::int64_t point_count = 0;  // measured points that it represents
};

struct Handle {
  int shape_index = -1;  // of the part that it begins at; -1: at a surface
  std::int64_t point_count = 0;
  Eigen::Vector3d axis_O = Eigen::Vector3d::Zero();  // unit
  OrientedBox bounds = {};
  std::string hash = {};  // of its mesh; empty: none
};

// How an object is attached to a robot: it moves with the link L.
struct Attachment {
  std::string robot;
  std::string link;
  Eigen::Isometry3d X_LO = Eigen::Isometry3d::Identity();
  std::vector<std::string> touch_links = {};  // those that it may touch besides `link`
};

struct Object {
  std::string name;
  std::string uid;
  ObjectKind kind = ObjectKind::kUser;
  Owner owner = Owner::kUser;
  ObjectState state = ObjectState::kUnknown;
  Eigen::Isometry3d X_WO = Eigen::Isometry3d::Identity();
  std::vector<Part> parts = {};
  std::vector<Surface> surfaces = {};
  std::vector<Handle> handles = {};
  std::string supported_by = {};
  std::optional<OrientedBox> bounds = {};  // absent: unbounded
  std::int64_t point_count = 0;
  std::int64_t create_revision = 0;
  std::int64_t geometry_revision = 0;
  std::int64_t pose_revision = 0;
  std::optional<Time> last_observed = {};  // absent: never
  double margin_m = 0;
  std::optional<Attachment> attachment = {};
  std::optional<bool> reachable = {};  // for supports; absent: not known
  Motion motion = Motion::kNotFollowed;
  Visibility visibility = Visibility::kNotFollowed;
  // False if it may have been swapped with an object of the same shape; absent: not followed.
  std::optional<bool> identity_certain = {};
  std::string carried_by = {};  // "robot/link" that it moves with though it is not attached

  // The revision that a change may expect.
  std::int64_t revision() const {
    return geometry_revision > pose_revision ? geometry_revision : pose_revision;
  }
};

// An object, a robot with all its links, or a single link. "*" is everything.
struct NamedThing {
  NamedThing() = default;
  NamedThing(std::string name, std::string link = {})  // NOLINT: implicit
      : name(std::move(name)), link(std::move(link)) {}
  NamedThing(const char* name) : name(name) {}  // NOLINT: implicit

  std::string name;
  std::string link;
};

// The rule of a pair, apart from its shapes.
struct PairRule {
  NamedThing a;
  NamedThing b;
  bool allowed = false;                 // the pair may collide
  bool check = false;                   // it is checked although the SRDF disables it
  std::optional<Time> expires = {};     // the end of `allowed`; absent: never
  std::optional<double> margin_m = {};  // in place of all other margins
};

}  // namespace cwm::CWM_API
