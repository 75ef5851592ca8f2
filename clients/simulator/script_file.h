// Reads scripts of sequences, as YAML. The format: sequence_format.md.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/simulation/sequence_script.h"

namespace cwm::simulator {

// chosen: longer or faster sequences are refused, so that a few lines of YAML cannot fill a disk.
inline constexpr double kMaxDuration_s = 3600;
inline constexpr double kMaxRate_hz = 1000;
inline constexpr int kMaxSensors = 16;
inline constexpr int kMaxRobots = 16;

// The files of a robot, by which a server can load it.
struct RobotFiles {
  std::string urdf_path = {};  // absolute
  std::vector<std::string> package_folders = {};
  Pose X_WB = Pose::Identity();  // of the robot's root
};

struct ScriptFile {
  perception::SequenceScript script = {};
  std::vector<RobotFiles> robots = {};  // in the order of the script's
};

// Reads the script and the scene, the robots and the meshes that it names, with paths relative to
// the script. INVALID_ARGUMENT "FILE:LINE: FIELD is VALUE, RULE" for any error: those of ReadScene,
// times outside the sequence, names that the scene or the robot does not have, events of an object
// that overlap or that it is not there for, joint values outside their limits.
absl::StatusOr<ScriptFile> ReadScript(const std::string& path);

}  // namespace cwm::simulator
