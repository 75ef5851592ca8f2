// A robot as the subject of a query, and its states, from the command line.
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
  std::string at;  // the place of the root link, see pose_argument.h; empty: where it stands
  cwm::v1::RobotScope scope = cwm::v1::ROBOT_SCOPE_UNSPECIFIED;
  cwm::v1::RobotGeometry geometry = cwm::v1::ROBOT_GEOMETRY_UNSPECIFIED;
  std::vector<std::string> paddings = {};  // in place of those of its load, see link_values.h
};

// Adds no option for `at`: what --at places is the command's choice.
void AddRobotOptions(CLI::App& command, RobotArguments& robot);
// True if any option but the name and `at` is set.
bool HasRobotOptions(const RobotArguments& robot);

// The subject without rows; `at_option` is named by errors of `at`.
absl::StatusOr<cwm::v1::RobotSubject> ParseRobotSubject(Session& session,
                                                        const RobotArguments& robot,
                                                        const std::string& at_option);

// A row of the subject's group: "0.1,0.2,..." unchanged (the server checks the count), or a state
// that the SRDF names, in that group or, without a group, in any. The server is asked for it;
// joints that the state does not name keep their present values.
absl::StatusOr<std::vector<double>> ParseJoints(Session& session, const std::string& text,
                                                const cwm::v1::RobotSubject& subject);

// The same text as a state to set: of all variables of the group (without a group, of the robot),
// or of those that the named state has.
absl::StatusOr<cwm::v1::RobotJointState> ParseJointState(Session& session, const std::string& text,
                                                         const cwm::v1::RobotSubject& subject);

}  // namespace cwm::cli
