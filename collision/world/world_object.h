// One object of the world, as immutable values. A move makes a new WorldObject that shares the
// model and its prepared geometry; a new model makes a new geometry revision.
#pragma once

#include <algorithm>
#include <compare>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "collision/engines/prepared_shape.h"
#include "collision/geometry/hybrid_model.h"

namespace cwm::collision {

// The number of atomic changes of one world, from 0 (empty, never changed).
struct Revision {
  std::int64_t value = 0;
  friend auto operator<=>(const Revision&, const Revision&) = default;
};

// kMover: a piece of something that moves and is not modelled, for as long as a sensor sees it.
enum class ObjectKind : std::uint8_t { kSupport, kObject, kResidual, kUnseen, kUser, kMover };
enum class Owner : std::uint8_t { kPerception, kUser };
enum class ObjectState : std::uint8_t { kConfirmed, kOccluded, kLost };

std::string_view NameOf(ObjectKind kind);    // "SUPPORT" ...
std::string_view NameOf(Owner owner);        // "PERCEPTION", "USER"
std::string_view NameOf(ObjectState state);  // "CONFIRMED" ...

// The origin of a collision part in its model.
enum class PartSource { kShape, kSurface, kHandle };

// One part of a model, ready for every engine.
struct PreparedPart {
  PartSource source = PartSource::kShape;
  int index = 0;                 // into the model's shapes, surfaces or handles
  Pose X_OP = Pose::Identity();  // the part in the object's frame
  Shape shape;
  Aabb bounds_O;       // tight, object's frame
  double sigma_m = 0;  // SurfaceSigma_m for shapes; 0 for surfaces and handles, which have no fit
  PreparedShape engines;
};

// A part at its object's pose, as broad phase and engines use it. Computed when the object is put
// or moved, not for each query.
struct PlacedPart {
  Pose X_WP = Pose::Identity();
  Aabb bounds_W;  // tight
};

// A hybrid model with its geometry prepared for each engine. Immutable, shared by all revisions
// that have it.
struct PreparedModel {
  std::shared_ptr<const HybridModel> model;
  std::vector<PreparedPart>
      parts;                // shapes, then surfaces, then handles, each in the model's order
  double max_sigma_m = 0;   // the largest of all parts
  double max_hidden_m = 0;  // the largest HiddenDepth_m of all shapes
  bool has_caps = false;    // true if holes of a mesh were closed (HasCaps)
  std::int64_t weight = 0;  // the sum over all parts, see QueryCost
};

// The relative cost of a query about a shape whose box is near; a primitive costs 1. A mesh costs
// more with the levels of its tree, a hull or plate with its corners.
std::int64_t QueryCost(const Shape& shape);

// Builds trees and hulls, which is slow; do not hold a lock. Surfaces without triangles make no
// part; a handle without triangles is represented by its bounding box. `model` is not null and its
// shapes are valid (FindViolation). nullptr if `work` stopped the function.
std::shared_ptr<const PreparedModel> Prepare(std::shared_ptr<const HybridModel> model,
                                             WorkCounter* work = nullptr);
// TightBounds of a part at pose X_FP, in a few microseconds for any number of triangles.
Aabb BoundsAt(const PreparedPart& part, const Pose& X_FP);

struct RobotGeometry;  // world_robot.h

// An obstacle for queries: an object of the world, or a robot of the world in its state.
struct Obstacle {
  std::string name;  // unique in its world, among objects and robots
  std::shared_ptr<const PreparedModel> geometry;
  double margin_m = 0;
  // For a robot, whose parts are in the frames of their links; nullptr for an object.
  std::shared_ptr<const RobotGeometry> robot;

  // Derived from the pose; set by Place.
  std::vector<PlacedPart> parts_W;  // one per part of the geometry
  Aabb bounds_W;                    // around all of them; empty without parts
};

// The attachment of an object, which moves with the link: X_WO = X_WL * X_LO.
struct Attachment {
  std::string robot;
  std::string link;
  Pose X_LO = Pose::Identity();
  // Links of the robot that may touch the object besides `link`; ordered, each once. Links that a
  // later model of the robot lacks have no effect.
  std::vector<std::string> touch_links;
};

// A unique identifier: only one item of a name can be created per revision. Empty for revision 0,
// in which no world created anything.
std::string UidOf(const std::string& name, Revision create_revision);

struct WorldObject : Obstacle {
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const Attachment> attachment;  // nullptr: not attached
  std::string supported_by;    // name of the support or object on which it stands; may be empty
  Revision create_revision;    // 0: not yet part of a world
  Revision geometry_revision;  // last change of the model
  Revision pose_revision;      // last change of the pose or of the attachment
  ObjectKind kind = ObjectKind::kUser;
  Owner owner = Owner::kUser;
  ObjectState state = ObjectState::kConfirmed;

  const HybridModel& model() const { return *geometry->model; }

  // A unique identifier; an object that is removed and put again gets a new one. Empty for an
  // object that no world created.
  std::string Uid() const { return UidOf(name, create_revision); }
  bool IsSameAs(const WorldObject& other) const {
    return create_revision == other.create_revision && name == other.name;
  }

  // The revision that a writer gives as `expected_object_revision`.
  Revision latest_revision() const { return std::max(geometry_revision, pose_revision); }
};

// True if the obstacle is unseen space, which no sensor has observed.
inline bool IsUnseen(const Obstacle& obstacle) {
  return obstacle.robot == nullptr &&
         static_cast<const WorldObject&>(obstacle).kind == ObjectKind::kUnseen;
}

// The object with its parts placed at its pose, ready for a snapshot. nullptr if `work` stopped the
// function.
std::shared_ptr<const WorldObject> Place(WorldObject object, WorkCounter* work = nullptr);

// True for 1 to 128 letters, digits and "_-./", because names of objects appear in file names,
// tables and URLs.
bool IsValidName(std::string_view name);

}  // namespace cwm::collision
