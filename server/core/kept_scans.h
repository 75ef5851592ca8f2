// The newest scan of each sensor of a world, for display beside the objects that were made of it.
// Not a part of any revision.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/pose.h"
#include "collision/world/world_snapshot.h"
#include "server/core/geometry_store.h"
#include "server/core/limits.h"

namespace cwm::server {

struct IngestRequest;  // ingest.h
struct IngestOutcome;

struct KeptScan {
  std::string sensor;
  collision::Revision revision;  // the world's revision that includes this scan
  std::chrono::system_clock::time_point frame_stamp;
  Pose X_WC = Pose::Identity();
  std::int64_t point_count = 0;  // finite points of the scan
  std::int64_t kept_count = 0;   // those of them in the blobs
  HeldBlob points = {};          // in the world's frame
  HeldBlob labels = {};          // one per kept point
  // Names of the objects behind the labels, in label order; empty if the world has no such object.
  std::vector<std::string> supports = {}, objects = {};
};

// Puts the finite points and their labels into the store; if there are more than
// limits.max_kept_scan_points, an evenly spread selection of them. The errors of
// GeometryStore::Put.
absl::StatusOr<KeptScan> MakeKeptScan(const IngestRequest& request, const IngestOutcome& outcome,
                                      const Limits& limits, GeometryStore& store);

// Thread safe.
class KeptScans {
 public:
  // Replaces an older scan of the sensor, but not a newer one. If there are more than `max_sensors`
  // sensors, the scan with the oldest revision is forgotten.
  void Keep(KeptScan scan, std::int64_t max_sensors);
  // The sensor's scan was taken again at `stamp`, and shows the same but for noise: the kept points
  // stand for it. False if there is no scan of the sensor.
  bool Renew(const std::string& sensor, collision::Revision revision,
             std::chrono::system_clock::time_point stamp);
  std::vector<KeptScan> List() const;  // by sensor

 private:
  mutable std::mutex mutex_;
  std::map<std::string, KeptScan> by_sensor_;
};

}  // namespace cwm::server
