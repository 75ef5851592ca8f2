// One object of the world: immutable values. Moving it makes a new WorldObject that shares the
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

// Counts the atomic changes of one world, from 0 (empty, never changed).
struct Revision {
  std::int64_t value = 0;
  friend auto operator<=>(const Revision&, const Revision&) = default;
};

enum class ObjectKind : std::uint8_t { kSupport, kObject, kResidual, kUnseen, kUser };
enum class Owner : std::uint8_t { kPerception, kUser };
enum class ObjectState : std::uint8_t { kConfirmed, kOccluded, kLost };

std::string_view NameOf(ObjectKind kind);    // "SUPPORT" ...
std::string_view NameOf(Owner owner);        // "PERCEPTION", "USER"
std::string_view NameOf(ObjectState state);  // "CONFIRMED" ...

// Where a collision part comes from in its model.
enum class PartSource { kShape, kSurface, kHandle };

// One part of a model, ready for every engine.
struct PreparedPart {
  PartSource source = PartSource::kShape;
  int index = 0;                 // into the model's shapes, surfaces or handles
  Pose X_OP = Pose::Identity();  // the part in the object's frame
  Shape shape;
  Aabb bounds_O;       // tight, object's frame
  double sigma_m = 0;  // of a shape: SurfaceSigma_m; 0 for surfaces and handles, which have no fit
  PreparedShape engines;
};

// A part where its object is now: what broadphase and engines read, computed when the object is put
// or moved and not once per question.
struct PlacedPart {
  Pose X_WP = Pose::Identity();
  Aabb bounds_W;  // tight
};

// A hybrid model with its geometry prepared for each engine. Immutable, shared by all revisions
// that hold it.
struct PreparedModel {
  std::shared_ptr<const HybridModel> model;
  std::vector<PreparedPart>
      parts;                  // shapes, then surfaces, then handles, each in the model's order
  double widest_sigma_m = 0;  // of any part
  std::int64_t weight = 0;    // of all parts: see WeightOfAsking
};

// What it takes to ask about a shape once its box is near, a primitive taken as 1: a mesh by the
// levels of its tree, a hull or plate by its corners.
std::int64_t WeightOfAsking(const Shape& shape);

// Heavy: builds trees and hulls. Call it without any lock held. Surfaces without triangles make no
// part; a handle without triangles is its bounding box. `model` is not null and its shapes are
// valid (FindViolation).
// nullptr where `work` ended it.
std::shared_ptr<const PreparedModel> Prepare(std::shared_ptr<const HybridModel> model,
                                             WorkCounter* work = nullptr);
// TightBounds of a part where X_FP has it: some microseconds however many triangles it has.
Aabb BoundsAt(const PreparedPart& part, const Pose& X_FP);

struct RobotGeometry;  // world_robot.h

// What questions meet: an object of the world, or a robot of it where its state puts it.
struct Obstacle {
  std::string name;  // unique in its world, among objects and robots
  std::shared_ptr<const PreparedModel> geometry;
  double margin_m = 0;
  // Of a robot, of which each part is in the frame of its link; nullptr: an object.
  std::shared_ptr<const RobotGeometry> robot;

  // Follow from where it is; set by Place.
  std::vector<PlacedPart> parts_W;  // one per part of the geometry
  Aabb bounds_W;                    // around all of them; empty without parts
};

// What an object is attached by: it moves with the link, X_WO = X_WL * X_LO.
struct Attachment {
  std::string robot;
  std::string link;
  Pose X_LO = Pose::Identity();
  // Of the robot, that may touch the object besides `link`; ordered, none twice. Another model of
  // the robot may lack some: they mean nothing then.
  std::vector<std::string> touch_links;
};

// One thing of a name can be made per revision, so the two together are unique for ever. Empty for
// revision 0, in which no world made anything.
std::string UidOf(const std::string& name, Revision create_revision);

struct WorldObject : Obstacle {
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const Attachment> attachment;  // nullptr: stands free
  std::string supported_by;    // name of the support or object that carries it; may be empty
  Revision create_revision;    // 0: not of a world yet
  Revision geometry_revision;  // last change of the model
  Revision pose_revision;      // last change of the pose, or of what it is attached by
  ObjectKind kind = ObjectKind::kUser;
  Owner owner = Owner::kUser;
  ObjectState state = ObjectState::kConfirmed;

  const HybridModel& model() const { return *geometry->model; }

  // Unique for ever; one that is removed and put again gets a new one. Empty for an object that no
  // world made.
  std::string Uid() const { return UidOf(name, create_revision); }
  bool IsSameAs(const WorldObject& other) const {
    return create_revision == other.create_revision && name == other.name;
  }

  // What a writer states as `expected_object_revision`.
  Revision latest_revision() const { return std::max(geometry_revision, pose_revision); }
};

// Whether it is space that no sensor has seen.
inline bool IsUnseen(const Obstacle& obstacle) {
  return obstacle.robot == nullptr &&
         static_cast<const WorldObject&>(obstacle).kind == ObjectKind::kUnseen;
}

// The object with its parts placed at its pose, ready for a snapshot.
// nullptr where `work` ended it.
std::shared_ptr<const WorldObject> Place(WorldObject object, WorkCounter* work = nullptr);

// The rule for names of objects, which travel in file names, tables and URLs: 1 to 128 letters,
// digits and "_-./".
bool IsValidName(std::string_view name);

}  // namespace cwm::collision
