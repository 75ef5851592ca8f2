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

// The true label of every point, in the scheme of labelled clouds: 0 nothing, 1 to 9 the supports,
// 10 (i + 1) the i-th object that is no support, i from 1 on.
std::vector<std::uint32_t> TrueLabels(const perception::SimulatedScene& scene,
                                      const perception::SimulatedCloud& scan);

// JSON: x_world_sensor; for each object its name, label, whether it is a support, pose, centre,
// size and top of its axis-aligned bounds in the world, points that see it, and parts with kind,
// dimensions (metres, named as in cwm.v1), pose in the object and points; main_shape and radius_m
// repeat those of the first part. movable_index is the object that one may move by some
// centimetres; -1: none. Poses are objects with tx_m ty_m tz_m qx qy qz qw.
std::string TruthJson(const perception::SimulatedScene& scene,
                      const perception::PinholeCamera& camera,
                      const perception::SimulatedCloud& scan);

}  // namespace cwm::simulator
