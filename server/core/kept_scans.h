// The newest scan of each sensor of a world, to look at beside what was made of it: no part of any
// revision.
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
  collision::Revision revision;  // of the world, with this scan in it
  std::chrono::system_clock::time_point frame_stamp;
  Pose X_WC = Pose::Identity();
  std::int64_t point_count = 0;  // finite ones
  std::int64_t kept_count = 0;   // of those, in the blobs
  HeldBlob points = {};          // in the world's frame
  HeldBlob labels = {};          // one a kept point
  // Names behind the labels, in their order; empty where no object of the world is.
  std::vector<std::string> supports = {}, objects = {};
};

// The finite points and their labels into the store; of more than limits.max_kept_scan_points every
// so-manieth, evenly. The errors of GeometryStore::Put.
absl::StatusOr<KeptScan> MakeKeptScan(const IngestRequest& request, const IngestOutcome& outcome,
                                      const Limits& limits, GeometryStore& store);

// Thread safe.
class KeptScans {
 public:
  // In the place of an older one of the sensor; none in the place of a newer one. Of more than
  // `most` sensors the one that was heard least recently is forgotten.
  void Keep(KeptScan scan, std::int64_t most);
  std::vector<KeptScan> List() const;  // by sensor

 private:
  mutable std::mutex mutex_;
  std::map<std::string, KeptScan> by_sensor_;
};

}  // namespace cwm::server
