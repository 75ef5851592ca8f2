// Objects attached to a robot, as part of its query body.
#pragma once

#include <span>
#include <string>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// The number of parts that WithAttachedObjects would add to the robot's body.
std::size_t CountAttachedParts(const WorldSnapshot& world, const WorldRobot& robot,
                               std::span<const std::string> ignore = {});

// Adds the objects that the world has attached to the robot, ordered by name and without the
// ignored names. Unless the scope is kWorld, each object is tested against the robot's links,
// except the one that it is attached to and its touch links, and against attached objects on other
// links. The first part of these self pairs is that of the attached object.
//
// `body` is the result of BodyFromRobot or BodyFromSpheres; it is unchanged if nothing is attached.
QueryBody WithAttachedObjects(QueryBody body, const WorldSnapshot& world, const WorldRobot& robot,
                              RobotScope scope, std::span<const std::string> ignore = {});

}  // namespace cwm::collision
