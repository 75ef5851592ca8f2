// A simulated scan as files: the cloud, and what is true about it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "clients/formats/cloud_file.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::simulator {

// x y z in the sensor's frame, organised; NaN where nothing returned.
formats::CloudFile ToCloudFile(const perception::PointCloud& cloud);

// The true label of every point, in the scheme of labelled clouds: 0 nothing, 1 to 9 the supports
// (the tenth and later share 9); the i-th object that is no support, i from 1 on, takes
// 10 (i + 1) + part, with part 0 for an object of one part, else 1 for the first part to 9 for the
// ninth and all later ones.
std::vector<std::uint32_t> TrueLabels(const perception::SimulatedScene& scene,
                                      const perception::SimulatedCloud& scan);

// A scan with what is true about it besides its points.
struct SimulatedScan {
  perception::SimulatedCloud cloud;
  std::vector<Pose> X_WC = {};  // of each view; the cloud is in the frame of the first
  std::vector<Pose> X_CC = {};  // of each view in the first, as registration believes
  Vector3 up_C = Vector3::UnitZ();
};

// JSON: x_world_sensor; camera; up_sensor, the up vector in the sensor's frame, off as asked for;
// views, where there are several, with their true and their believed pose; for each object its
// name, label, whether it is a support, whether it is shiny, pose, centre, size and top of its
// axis-aligned bounds in the world (null where infinite), points that see it, hidden_fraction (of
// the pixels in which the first camera would see it if it were alone, the share in which something
// else is nearer), and parts with kind, role, dimensions (metres, named as in cwm.v1), pose in the
// object, label and points; main_shape and radius_m repeat those of the first part. movable_index is
// the object that one may move by some centimetres; -1: none. Poses are objects with tx_m ty_m tz_m
// qx qy qz qw.
std::string TruthJson(const perception::SimulatedScene& scene,
                      const perception::PinholeCamera& camera, const SimulatedScan& scan);

}  // namespace cwm::simulator
