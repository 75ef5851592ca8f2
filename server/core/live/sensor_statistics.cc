#include "server/core/live/sensor_statistics.h"

#include <algorithm>
#include <vector>

namespace cwm::server {
namespace {

// The least value that at least this share of the sorted values does not exceed.
double Quantile(const std::vector<double>& sorted, double share) {
  const auto last = static_cast<double>(sorted.size() - 1);
  return sorted[static_cast<std::size_t>(share * last + 0.5)];
}

}  // namespace

void SensorStatistics::NoteProcessed(Clock::time_point now, double latency_ms, double delay_ms) {
  ++processed_;
  entries_.push_back({now, latency_ms, delay_ms});
  if (entries_.size() > kFrames) entries_.pop_front();
}

void SensorStatistics::Fill(Clock::time_point now, SensorStatus& status) const {
  status.processed = processed_;
  status.dropped = dropped_;
  status.refused = refused_;
  if (entries_.empty()) return;
  std::vector<double> latencies_ms;
  double delay_ms = entries_.front().delay_ms;
  const Entry* first = nullptr;
  int recent = 0;
  for (const Entry& entry : entries_) {
    latencies_ms.push_back(entry.latency_ms);
    delay_ms = std::min(delay_ms, entry.delay_ms);
    if (now - entry.when > kRateTime) continue;
    if (first == nullptr) first = &entry;
    ++recent;
  }
  std::ranges::sort(latencies_ms);
  status.latency_p50_ms = Quantile(latencies_ms, 0.5);
  status.latency_p95_ms = Quantile(latencies_ms, 0.95);
  status.delay_ms = delay_ms;
  if (recent < 2) return;
  const std::chrono::duration<double> span = entries_.back().when - first->when;
  if (span.count() > 0) status.frame_rate_Hz = (recent - 1) / span.count();
}

}  // namespace cwm::server
