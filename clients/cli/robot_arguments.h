// A robot that asks, and its states, from the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/cli/session.h"
#include "cwm/v1/query.pb.h"

namespace cwm::cli {

struct RobotArguments {
  std::string name, group;
  std::vector<std::string> joints;  // states: numbers, or names; "-": JSON lines on stdin
  std::string x_world_base;
  cwm::v1::RobotScope scope = cwm::v1::ROBOT_SCOPE_UNSPECIFIED;
  cwm::v1::RobotGeometry geometry = cwm::v1::ROBOT_GEOMETRY_UNSPECIFIED;
};

void AddRobotOptions(CLI::App& command, RobotArguments& robot);
// Whether any option but the name is set.
bool HasAny(const RobotArguments& robot);

// Without rows.
absl::StatusOr<cwm::v1::RobotSubject> ToRobotSubject(const RobotArguments& robot);

// A row of the subject's group: "0.1,0.2,..." as it is (the server checks how many there are), or a
// state that the SRDF names, of that group or, without one, of any. The server is asked for it;
// what the state does not name is where the robot has it.
absl::StatusOr<std::vector<double>> ParseJoints(Session& session, const std::string& text,
                                                const cwm::v1::RobotSubject& subject);

// The same text as a state to be set: of all variables of the group (all of the robot's without one),
// or of those that the named state has.
absl::StatusOr<cwm::v1::RobotJointState> ParseJointState(Session& session, const std::string& text,
                                                         const cwm::v1::RobotSubject& subject);

}  // namespace cwm::cli
