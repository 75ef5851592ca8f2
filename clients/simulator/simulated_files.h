// Writes a simulated scan as files: the cloud and its ground truth.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/formats/cloud_file.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::simulator {

// x y z in the sensor's frame, organised; NaN for pixels without a return.
formats::CloudFile ToCloudFile(const perception::PointCloud& cloud);

// The true label of every point, in the scheme of labelled clouds: 0 nothing, 1 to 9 the supports
// (the tenth and later share 9); the i-th other object (from 1) has 10 (i + 1) + part, where part
// is 0 for an object of one part, otherwise 1 for the first part to 9 for the ninth and all later
// ones.
std::vector<std::uint32_t> TrueLabels(const perception::SimulatedScene& scene,
                                      const perception::SimulatedCloud& scan);

// A scan with its ground truth besides the points.
struct SimulatedScan {
  perception::SimulatedCloud cloud;
  std::vector<Pose> X_WC = {};  // of each view; the cloud is in the first view's frame
  std::vector<Pose> X_CC = {};  // of each view in the first, as estimated by registration
  Vector3 up_C = Vector3::UnitZ();
};

// JSON: x_world_sensor; camera; up_sensor, the up vector in the sensor's frame, with the requested
// error; views, if there are several, with their true and their estimated pose; for each object its
// name, label, whether it is a support, whether it is shiny, pose, centre, size and top of its
// axis-aligned bounds in the world (null if infinite), visible points, hidden_fraction (of the
// pixels in which the first camera would see it if it were alone, the share in which something else
// is nearer), and parts with kind, role, dimensions (metres, named as in cwm.v1), pose in the
// object, label and points; main_shape and radius_m repeat those of the first part. movable_index
// is the object that may be moved by some centimetres; -1: none. Poses are objects with tx_m ty_m
// tz_m qx qy qz qw.
std::string TruthJson(const perception::SimulatedScene& scene,
                      const perception::PinholeCamera& camera, const SimulatedScan& scan);

}  // namespace cwm::simulator
