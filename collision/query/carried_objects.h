// What is attached to a robot that asks, as part of its body.
#pragma once

#include <span>
#include <string>

#include "collision/query/query.h"
#include "collision/query/robot_body.h"

namespace cwm::collision {

// How many parts that is, of a robot that asks: what WithCarriedObjects adds, to be told before.
std::size_t CountCarriedParts(const WorldSnapshot& world, const WorldRobot& robot,
                              std::span<const std::string> ignore = {});

// The body of the robot with what the world has attached to it but for the names that are ignored;
// ordered by name. Unless the scope is the world alone, each object is asked of the robot's links
// but the one that it is attached to and those that it may touch, and of the others but those on
// the same link: pairs of which the first part is the carried one.
//
// The body is as BodyFromRobot and BodyFromSpheres make it; where nothing is attached it stays so.
QueryBody WithCarriedObjects(QueryBody body, const WorldSnapshot& world, const WorldRobot& robot,
                             RobotScope scope, std::span<const std::string> ignore = {});

}  // namespace cwm::collision
