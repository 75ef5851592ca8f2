#include "server/core/kept_scans.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "perception/cloud/returns.h"
#include "server/core/ingest.h"

namespace cwm::server {
namespace {

struct Columns {
  std::string points;
  std::string labels;
};

std::int64_t CountReturns(const std::vector<Eigen::Vector3f>& points) {
  return std::count_if(points.begin(), points.end(),
                       [](const Eigen::Vector3f& point) { return perception::IsReturn(point); });
}

// Selects `kept` of the `returns` finite points, evenly spread; all of them if both numbers are the
// same.
Columns Subsample(const IngestRequest& request, const IngestOutcome& outcome, std::int64_t returns,
                  std::int64_t kept) {
  Columns columns;
  columns.points.resize(static_cast<std::size_t>(kept) * 3 * sizeof(float));
  columns.labels.resize(static_cast<std::size_t>(kept) * sizeof(std::uint32_t));
  char* point_out = columns.points.data();
  char* label_out = columns.labels.data();
  const Pose X_WV = outcome.X_WC * Eigen::Translation3d(request.viewpoint_C);
  std::int64_t met = 0;
  for (std::size_t i = 0; i < request.cloud.points.size(); ++i) {
    const Eigen::Vector3f& p_VP = request.cloud.points[i];
    if (!perception::IsReturn(p_VP)) continue;
    const std::int64_t before = met++ * kept / returns;
    if (met * kept / returns == before) continue;
    const Eigen::Vector3f p_WP = (X_WV * p_VP.cast<double>()).cast<float>();
    std::memcpy(point_out, p_WP.data(), 3 * sizeof(float));
    std::memcpy(label_out, &outcome.labels[i], sizeof(std::uint32_t));
    point_out += 3 * sizeof(float);
    label_out += sizeof(std::uint32_t);
  }
  return columns;
}

std::vector<std::string> NamesOf(const std::vector<collision::WorldObjectPtr>& objects) {
  std::vector<std::string> names;
  for (const collision::WorldObjectPtr& object : objects) {
    // An object without a uid belongs to no world.
    names.push_back(object == nullptr || object->Uid().empty() ? "" : object->name);
  }
  return names;
}

}  // namespace

absl::StatusOr<KeptScan> MakeKeptScan(const IngestRequest& request, const IngestOutcome& outcome,
                                      const Limits& limits, GeometryStore& store) {
  KeptScan scan{.sensor = request.sensor,
                .revision = outcome.revision,
                .frame_stamp = request.taken_at(),
                .X_WC = outcome.X_WC,
                .point_count = CountReturns(request.cloud.points),
                .supports = NamesOf(outcome.supports),
                .objects = NamesOf(outcome.objects)};
  scan.kept_count = std::min(scan.point_count, limits.max_kept_scan_points);
  Columns columns = Subsample(request, outcome, scan.point_count, scan.kept_count);
  auto points = store.PutTemporary(BlobFormat::kPointsF32, std::move(columns.points));
  if (!points.ok()) return points.status();
  auto labels = store.PutTemporary(BlobFormat::kLabelsU32, std::move(columns.labels));
  if (!labels.ok()) return labels.status();
  scan.points = *std::move(points);
  scan.labels = *std::move(labels);
  return scan;
}

void KeptScans::Keep(KeptScan scan, std::int64_t max_sensors) {
  KeptScan replaced;  // its blobs are freed after the lock
  const std::lock_guard lock(mutex_);
  KeptScan& place = by_sensor_[scan.sensor];
  if (place.revision.value > scan.revision.value) return;
  replaced = std::exchange(place, std::move(scan));
  if (static_cast<std::int64_t>(by_sensor_.size()) <= max_sensors) return;
  const auto oldest =
      std::min_element(by_sensor_.begin(), by_sensor_.end(), [](const auto& a, const auto& b) {
        return a.second.revision.value < b.second.revision.value;
      });
  replaced = std::move(oldest->second);
  by_sensor_.erase(oldest);
}

bool KeptScans::Renew(const std::string& sensor, collision::Revision revision,
                      std::chrono::system_clock::time_point stamp) {
  const std::lock_guard lock(mutex_);
  const auto found = by_sensor_.find(sensor);
  if (found == by_sensor_.end()) return false;
  KeptScan& scan = found->second;
  if (scan.revision.value > revision.value) return true;
  scan.revision = revision;
  scan.frame_stamp = stamp;
  return true;
}

std::vector<KeptScan> KeptScans::List() const {
  const std::lock_guard lock(mutex_);
  std::vector<KeptScan> scans;
  scans.reserve(by_sensor_.size());
  for (const auto& [sensor, scan] : by_sensor_) scans.push_back(scan);
  return scans;
}

}  // namespace cwm::server
