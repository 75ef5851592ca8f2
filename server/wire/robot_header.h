// What a client says of a robot before its files.
#pragma once

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "cwm/v1/robot.pb.h"
#include "server/core/load_robot.h"
#include "server/wire/field_path.h"
#include "server/wire/robots.h"

namespace cwm::server {

// A text, or the name of the file that holds it.
struct TextSource {
  std::string text;
  std::string file;  // non-empty: this one
};

struct RobotPlan {
  std::string world;
  std::string world_uid;
  std::string name;  // empty: the URDF's
  TextSource urdf;
  std::optional<TextSource> srdf;
  std::optional<TextSource> spheres;
  Pose X_WB = Pose::Identity();
  collision::JointValues initial_state;
  WriteOptions write;
};

absl::StatusOr<RobotPlan> FromProto(const v1::LoadRobotHeader& header, const FieldPath& path);

// The files as ReadRobot takes them. INVALID_FIELD below `path` names a text whose file did not
// come. `files` gives away what it holds.
absl::StatusOr<RobotFiles> FilesOf(const RobotPlan& plan,
                                   std::map<std::string, std::string, std::less<>> files,
                                   const FieldPath& path);

// The robot as the world is to hold it: the plan's name or the URDF's, the state that the plan's
// joints make of the default. Errors below `path`: a name that no robot may have, joints and states
// that this one does not have.
absl::StatusOr<collision::PutRobot> PutOf(const RobotPlan& plan,
                                          std::shared_ptr<const collision::RobotGeometry> robot,
                                          const FieldPath& path);

}  // namespace cwm::server
