// Names of sensor models, on the command line and in scripts.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "perception/cloud/sensor_noise.h"

namespace cwm::simulator {

// kinect, realsense, time_of_flight, tilting_laser, sick_lms400, or a positive standard deviation
// in metres. Empty for anything else.
std::optional<perception::SensorNoise> ParseSensorModel(const std::string& text);

// The name of a model, "given" for a standard deviation.
std::string_view SensorModelName(perception::SensorModel model);

}  // namespace cwm::simulator
