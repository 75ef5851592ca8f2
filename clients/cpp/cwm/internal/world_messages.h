// Objects, robots, rules and changes as messages and back.
#pragma once

#include <string>
#include <variant>
#include <vector>

#include "cwm/changes.h"
#include "cwm/internal/geometry_messages.h"
#include "cwm/objects.h"
#include "cwm/robots.h"
#include "cwm/scans.h"
#include "cwm/v1/perception.pb.h"
#include "cwm/v1/robot_model.pb.h"
#include "cwm/v1/world.pb.h"

namespace cwm::CWM_API::internal {

Time FromMessage(const google::protobuf::Timestamp& stamp);
google::protobuf::Timestamp ToMessage(Time stamp);
// Throws kInvalidArgument with the name for a time that is negative or not finite.
google::protobuf::Duration DurationFrom(double seconds, const std::string& name);

Object FromMessage(const v1::Object& object);
Robot FromMessage(const v1::Robot& robot);
PairRule FromMessage(const v1::PairRule& rule);

void SetSensor(const std::variant<SensorModel, SensorNoise>& sensor, v1::SensorModel& message);

v1::NamedThing ToMessage(const NamedThing& thing);
v1::NamedPair ToMessage(const NamedThing& a, const NamedThing& b);
v1::RobotJointState ToMessage(const JointState& state);
v1::LinkPadding ToMessage(const LinkPadding& padding);
v1::RobotTool ToMessage(const Tool& tool, const std::string& name);
// Appends the meshes that the change needs.
v1::Change ToMessage(const Change& change, const std::string& name, std::vector<MeshBlob>& meshes);

}  // namespace cwm::CWM_API::internal
