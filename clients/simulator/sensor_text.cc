#include "clients/simulator/sensor_text.h"

#include <array>
#include <cmath>
#include <utility>

#include "absl/strings/numbers.h"

namespace cwm::simulator {
namespace {

using perception::SensorModel;

constexpr std::array<std::pair<std::string_view, SensorModel>, 5> kModelNames = {
    {{"kinect", SensorModel::kKinect},
     {"realsense", SensorModel::kRealSense},
     {"time_of_flight", SensorModel::kTimeOfFlight},
     {"tilting_laser", SensorModel::kTiltingLaser},
     {"sick_lms400", SensorModel::kSickLms400}}};

}  // namespace

std::optional<perception::SensorNoise> ParseSensorModel(const std::string& text) {
  perception::SensorNoise noise;
  for (const auto& [name, model] : kModelNames) {
    if (name != text) continue;
    noise.model = model;
    return noise;
  }
  noise.model = SensorModel::kGiven;
  const bool good = absl::SimpleAtod(text, &noise.given_sigma_m) &&
                    std::isfinite(noise.given_sigma_m) && noise.given_sigma_m > 0;
  return good ? std::optional(noise) : std::nullopt;
}

std::string_view SensorModelName(perception::SensorModel model) {
  for (const auto& [name, known] : kModelNames) {
    if (known == model) return name;
  }
  return "given";
}

}  // namespace cwm::simulator
