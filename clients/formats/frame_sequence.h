// Sequences of depth images or clouds as folders or lists of files, with stamps and poses.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "absl/status/statusor.h"
#include "clients/formats/scene_pose.h"

namespace cwm::formats {

// Times are seconds of the recording's clock, whose zero may be anywhere.
struct SequenceFrame {
  std::string path;    // of a depth image or a cloud
  std::string source;  // "DIR/frames.jsonl:3" or the path, for errors
  std::optional<double> stamp_s = {};
  std::optional<double> delivery_s = {};  // when it arrived; absent: at its stamp
  std::optional<ScenePose> x_world_sensor = {};
};

// The values of a robot's variables at a moment, rad or m.
struct SequenceState {
  std::string robot;
  std::string source;
  double stamp_s = 0;
  double delivery_s = 0;
  std::vector<std::string> variables = {};  // empty: all, in the robot's order
  std::vector<double> values = {};
};

struct FrameSequence {
  std::vector<SequenceFrame> frames = {};  // in the order of their delivery
  std::vector<SequenceState> states = {};  // likewise
};

// Reads the frames of a folder: those of its frames.jsonl, with the states of a joint_states.jsonl
// in it or in the folder above; else its files in the order of their names, numbers by their value:
// depth images (PNG, NPY; of those alone whose names end in "depth" if there are any), or else
// clouds (PCD, PLY). A frame NAME.png has its pose in NAME.pose.txt; NAME-depth.png has it in
// NAME-pose.txt, NAME.depth.png in NAME.pose.txt. If there is a gravity-direction.txt, these poses
// are turned so that z is up. INVALID_ARGUMENT names file and line.
absl::StatusOr<FrameSequence> ReadFrameFolder(const std::string& folder);

// Reads a line of a list of frames: FILE [STAMP [POSE]], or an object as in frames.jsonl. The
// POSE is X,Y,Z,QX,QY,QZ,QW or the name of a file, see ParsePoseFile. Paths are relative to
// `folder`. Empty for a line without words.
absl::StatusOr<std::optional<SequenceFrame>> ParseFrameLine(std::string_view line,
                                                            const std::string& folder,
                                                            const std::string& source);

// The file of the folder that describes its camera: camera.json, camera.yaml, camera-intrinsics.txt
// or intrinsics.txt. Empty if there is none.
std::string FindCameraFile(const std::string& folder);

}  // namespace cwm::formats
