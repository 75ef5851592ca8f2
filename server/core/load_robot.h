// Loads the files of a robot into a world.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/robot/robot_settings.h"
#include "server/core/limits.h"
#include "server/core/world.h"

namespace cwm::server {

struct RobotFiles {
  std::string urdf;
  std::optional<std::string> srdf = {};
  std::optional<std::string> spheres = {};  // a spherized URDF
  // Mesh files by the URI that the URDF uses for them.
  std::map<std::string, std::string, std::less<>> meshes = {};
  collision::RobotSettings settings = {};
  // Names all of these in a store (Journal::KeepRobotFiles); empty if none keeps them.
  std::string files_hash = {};
};

// Reads and prepares a robot. Heavy, so no lock may be held. InvalidArgument INVALID_FIELD
// ("header.urdf", "header.srdf" or "header.spheres") for an error in a file, with its place and the
// rule; a mesh that is not among the files is named with its URI and link. The same for settings of
// links and groups that the robot does not have ("header.link_padding[0].link" and the like).
// ResourceExhausted ROBOT_TOO_LARGE if `limits` are exceeded. Cancelled when stopped, which is
// checked before each mesh and each stage. The robot gets the `files_hash` of the files.
absl::StatusOr<std::shared_ptr<const collision::RobotGeometry>> ReadRobot(
    RobotFiles files, const collision::RobotLimits& limits, const std::stop_token& stop);

// Warnings that a user should know before trusting answers about the robot: open meshes, moved
// links without collision geometry, a missing SRDF, or parts of it that were ignored; pairs of
// links that collide in every sampled state, and named states, or `state`, in self-collision.
std::vector<std::string> WarningsOf(const collision::RobotGeometry& robot, bool has_srdf,
                                    std::span<const double> state);

// Publishes one change. InvalidArgument INVALID_FIELD ("header.name") if an object has the name,
// ResourceExhausted TOO_MANY_ROBOTS, the errors of World::Update.
absl::StatusOr<WriteOutcome> LoadRobot(World& world, const collision::PutRobot& put,
                                       const WriteOptions& options, const Limits& limits);

// NotFound ROBOT_UNKNOWN, the errors of World::Update.
absl::StatusOr<WriteOutcome> RemoveRobot(World& world, const std::string& name,
                                         const WriteOptions& options);

// NotFound ROBOT_UNKNOWN.
absl::Status UnknownRobot(std::string_view name);
// ResourceExhausted ROBOT_TOO_LARGE; `message` names what is too large and the limit.
absl::Status RobotTooLarge(std::string message);

}  // namespace cwm::server
