// Reads poses and lenses of cameras in YAML. The format: scene_format.md.
#pragma once

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "clients/simulator/yaml_node.h"
#include "collision/geometry/pose.h"
#include "perception/simulation/simulated_scene.h"

namespace cwm::simulator {

absl::StatusOr<Vector3> ReadVector(const YamlNode& node);

// A map of position_m and either quaternion_xyzw or rpy_deg, all optional; the identity if it is
// not present.
absl::StatusOr<Pose> ReadPose(const YamlNode& node);

// The optical frame of a camera, under the key "pose" or "look_at" of the node.
absl::StatusOr<Pose> ReadViewpoint(const YamlNode& node);

// Reads width, height, focal_px and center_px of the node into the camera.
absl::Status ReadLens(const YamlNode& node, perception::PinholeCamera& camera);

}  // namespace cwm::simulator
