// One robot of the world, as immutable values. A motion makes a new WorldRobot that shares the
// model and its prepared geometry; another model under the same name makes another robot.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/robot/sphere_model.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

class ProgramCache;  // spheres/program_cache.h

// A sphere model ready for every engine: one part per sphere, in the frame of its link, ordered by
// link and within a link as listed. Immutable, shared.
struct PreparedSpheres {
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> link_of_part;  // ascending
};
// Spheres that contain the links, with the links' own geometry where the spheres say little.
struct PreparedBounds {
  std::shared_ptr<const PreparedModel> geometry = {};  // the spheres come first
  std::vector<int> link_of_part = {};  // ascending for the spheres, and for the others
  std::int32_t sphere_count = 0;
  // Self pairs of the model that are answered by the links' own geometry (FindTightPairs).
  std::vector<LinkPair> tight_pairs = {};
};
PreparedSpheres PrepareSpheres(const SphereModel& spheres);

// A robot ready for every engine. Immutable, shared by all revisions that have it.
struct RobotGeometry {
  std::shared_ptr<const RobotModel> model;
  // The collision geometries of all links as the shapes of one model, each in the frame of its LINK
  // (X_OP is X_LG): ordered by link, within a link in the order of its collisions. One part per
  // shape.
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> link_of_part;  // by part of `geometry`: index into model->links; ascending
  std::optional<SphereModel> spheres_as_given;               // absent if none were given
  std::optional<PreparedSpheres> prepared_spheres_as_given;  // likewise
  // Spheres that contain the links' geometry (FitBoundingSpheres); nullptr if a link has a
  // half-space, which no sphere contains.
  std::shared_ptr<const SphereModel> bounding_spheres;
  std::optional<PreparedBounds> prepared_bounds;  // of bounding_spheres
  std::shared_ptr<ProgramCache> programs;         // of queries about this robot
  // ModelLink::padding_m by part of `geometry`; empty if no link has a padding.
  std::vector<double> padding_of_part_m = {};
  // Names the files from which the robot was read, where a store keeps them; else empty.
  std::string files_hash = {};
};

// The paddings of the obstacle's parts, which are added to its margin; empty if there are none.
inline std::span<const double> PaddingsOf_m(const Obstacle& obstacle) {
  if (obstacle.robot == nullptr) return {};
  return obstacle.robot->padding_of_part_m;
}
// The margin of a part of the obstacle.
inline double MarginOf_m(const Obstacle& obstacle, std::size_t part) {
  const std::span<const double> paddings_m = PaddingsOf_m(obstacle);
  return obstacle.margin_m + (paddings_m.empty() ? 0 : paddings_m[part]);
}

// Builds trees and hulls, which is slow; do not hold a lock. `model` is not null. Checks `stop`
// every few milliseconds, and returns nullptr once it is requested.
std::shared_ptr<const RobotGeometry> PrepareRobot(std::shared_ptr<const RobotModel> model,
                                                  std::optional<SphereModel> spheres_as_given,
                                                  const std::stop_token& stop = {});

struct WorldRobot {
  std::string name;  // unique among robots and objects of its world
  std::shared_ptr<const RobotGeometry> robot;
  Pose X_WB = Pose::Identity();  // the root link in the world
  // One finite value for each variable of the model. Values may be outside the limits, as they are
  // if a robot was pushed there.
  std::vector<double> state;
  Revision create_revision;  // a new one if another model gets the name
  Revision state_revision;   // last change of X_WB or the state

  // Derived from the other members; set by Place.
  std::vector<Pose> X_WL;  // by link of the model
  Obstacle body;           // the robot as an obstacle: the parts of robot->geometry

  const RobotModel& model() const { return *robot->model; }

  // As for objects; robots and objects of one revision have different names.
  std::string Uid() const { return UidOf(name, create_revision); }
  bool IsSameAs(const WorldRobot& other) const {
    return create_revision == other.create_revision && name == other.name;
  }

  // The revision that a writer gives as `expected_object_revision`.
  Revision latest_revision() const { return state_revision; }
};

using WorldRobotPtr = std::shared_ptr<const WorldRobot>;

// Sets only the poses of the links.
void PlaceLinks(WorldRobot& robot);
// The robot with its links and their parts placed by base and state, ready for a snapshot.
WorldRobotPtr Place(WorldRobot robot);

// One difference between two revisions of a world.
struct RobotDelta {
  WorldRobotPtr before;  // nullptr: added
  WorldRobotPtr after;   // nullptr: removed
};

}  // namespace cwm::collision
