// Facts that belong to a write but to no revision: sightings of objects, poses of sensors.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "collision/geometry/pose.h"
#include "server/core/observations.h"

namespace cwm::server {

// The pose of a sensor, for scans that do not give it.
struct SensorPose {
  Pose X_WC = Pose::Identity();
  bool given = false;  // given by somebody, not estimated from a scan
};

struct NamedSensorPose {
  std::string sensor;
  SensorPose pose;
};

struct WriteFacts {
  std::vector<Sighting> sightings = {};                // of objects that the world has afterwards
  std::chrono::system_clock::time_point seen_at = {};  // when the scan was taken
  std::optional<NamedSensorPose> sensor_pose = {};
  bool empty() const { return sightings.empty() && !sensor_pose.has_value(); }
};

}  // namespace cwm::server
