// One robot of the world: immutable values. Its motion makes a new WorldRobot that shares the model
// and its prepared geometry; another model under the name makes another robot.
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "collision/robot/robot_model.h"
#include "collision/robot/sphere_model.h"
#include "collision/world/world_object.h"

namespace cwm::collision {

class ProgramMemo;  // spheres/program_memo.h

// A sphere model ready for every engine: one part a sphere, in the frame of its link, by link and
// within a link as listed. Immutable, shared.
struct PreparedSpheres {
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> link_of_part;  // ascending
};
PreparedSpheres PrepareSpheres(const SphereModel& spheres);

// A robot ready for every engine. Immutable, shared by all revisions that hold it.
struct RobotGeometry {
  std::shared_ptr<const RobotModel> model;
  // The collision geometries of all links as the shapes of one model, each placed in the frame of
  // its LINK (X_OP is X_LG): by link in the order of the model, within a link in the order of its
  // collisions. One part a shape.
  std::shared_ptr<const PreparedModel> geometry;
  std::vector<int> link_of_part;  // by part of `geometry`: index into model->links; ascending
  std::optional<SphereModel> spheres_as_given;               // absent where none were given
  std::optional<PreparedSpheres> prepared_spheres_as_given;  // likewise
  // That contain the links' geometry (SpheresAround); nullptr where a link has none, or goes on for
  // ever.
  std::shared_ptr<const SphereModel> spheres_around;
  std::optional<PreparedSpheres> prepared_spheres_around;  // of those
  std::shared_ptr<ProgramMemo> programs;                   // of questions about this robot
};

// Heavy: builds trees and hulls. Call it without any lock held. `model` is not null. Looks at `stop`
// every few milliseconds: nullptr once it is requested.
std::shared_ptr<const RobotGeometry> PrepareRobot(std::shared_ptr<const RobotModel> model,
                                                  std::optional<SphereModel> spheres_as_given,
                                                  const std::stop_token& stop = {});

struct WorldRobot {
  std::string name;  // unique among robots and objects of its world
  std::shared_ptr<const RobotGeometry> robot;
  Pose X_WB = Pose::Identity();  // the root link in the world
  // One finite value for each variable of the model; may lie outside its limits, as the joints of a
  // robot that was pushed there do.
  std::vector<double> state;
  Revision create_revision;  // of another model under the name a new one
  Revision state_revision;   // last change of X_WB or the state

  // Follow from the rest; set by Place.
  std::vector<Pose> X_WL;  // by link of the model
  Obstacle body;           // as others meet it: the parts of robot->geometry

  const RobotModel& model() const { return *robot->model; }

  // As of objects; no name is a robot's and an object's in one revision.
  std::string Uid() const { return UidOf(name, create_revision); }
  bool IsSameAs(const WorldRobot& other) const {
    return create_revision == other.create_revision && name == other.name;
  }

  // What a writer states as `expected_object_revision`.
  Revision latest_revision() const { return state_revision; }
};

using WorldRobotPtr = std::shared_ptr<const WorldRobot>;

// The poses of the links alone.
void PlaceLinks(WorldRobot& robot);
// The robot with its links and their parts where its base and state put them, ready for a snapshot.
WorldRobotPtr Place(WorldRobot robot);

// What differs between two revisions of a world.
struct RobotDelta {
  WorldRobotPtr before;  // nullptr: added
  WorldRobotPtr after;   // nullptr: removed
};

}  // namespace cwm::collision
