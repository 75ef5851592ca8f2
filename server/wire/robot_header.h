// The header of a robot's upload, which precedes its files.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/robot.pb.h"
#include "server/core/load_robot.h"
#include "server/wire/field_path.h"
#include "server/wire/robots.h"

namespace cwm::server {

// A text, or the name of the file that has it.
struct TextSource {
  std::string text;
  std::string file;  // if not empty, the file to use
};

struct RobotPlan {
  std::string world;
  std::string world_uid;
  std::string name;  // empty: the URDF's name
  TextSource urdf;
  std::optional<TextSource> srdf;
  std::optional<TextSource> spheres;
  Pose X_WB = Pose::Identity();
  collision::JointValues initial_state;
  collision::RobotSettings settings;
  WriteOptions write;
};

absl::StatusOr<RobotPlan> RobotPlanFromProto(const v1::LoadRobotHeader& header,
                                             const FieldPath& path);

// The files as input of ReadRobot. INVALID_FIELD below `path` names a text whose file was not sent.
// Moves the contents out of `files`.
absl::StatusOr<RobotFiles> MakeRobotFiles(const RobotPlan& plan,
                                          std::map<std::string, std::string, std::less<>> files,
                                          const FieldPath& path);

// The robot to put into the world: with the plan's name or the URDF's, and with the default state
// changed by the plan's joints. Errors below `path`: an invalid name, joints and states that the
// robot does not have.
absl::StatusOr<collision::PutRobot> MakePutRobot(
    const RobotPlan& plan, std::shared_ptr<const collision::RobotGeometry> robot,
    const FieldPath& path);

}  // namespace cwm::server
