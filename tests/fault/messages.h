// Converts between the checker's values and messages.
#pragma once

#include <string>

#include "cwm/v1/robot.pb.h"
#include "cwm/v1/world.pb.h"
#include "tests/fault/history.h"

namespace cwm::fault {

// Not for robots that are loaded or deleted, which have calls of their own.
v1::Change ToMessage(const Change& change);

// A geometry text is "box:X:Y:Z" in 1/1024 m or "mesh:HASH". What the histories never put, such as
// a rotation, becomes part of the text, so that it differs.
ModelObject ToObject(const v1::Object& object);
ModelRobot ToRobot(const v1::Robot& robot);
ModelRule ToRule(const v1::PairRule& rule);
std::string KeyOf(const v1::PairRule& rule);

WatchMessage ToWatchMessage(const v1::WatchWorldResponse& response, std::int64_t time_ns);

}  // namespace cwm::fault
