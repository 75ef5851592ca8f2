#include "server/store/history_window.h"

#include <chrono>

namespace cwm::server {

void HistoryWindow::Add(const Entry& entry) {
  entries_.push_back(entry);
  revisions_ += entry.changes > 0 ? 1 : 0;
  changes_ += entry.changes;
  geometry_bytes_ += entry.geometry_bytes;
}

// The newest revision stays, since the newest event of a world is always kept.
bool HistoryWindow::IsOldestOut(std::int64_t now_ns) const {
  const Entry& oldest = entries_.front();
  if (oldest.changes == 0) return true;
  if (revisions_ <= 1) return false;
  // Between n snapshots are n - 1 events.
  const bool is_exact =
      revisions_ < retention_.exact_snapshots && geometry_bytes_ <= retention_.snapshot_bytes;
  const std::int64_t watch_ns = std::chrono::nanoseconds(retention_.watch_time).count();
  // Divided, so that no clock of a damaged store overflows.
  const bool is_watched = oldest.when_ns / 2 >= now_ns / 2 - watch_ns / 2 &&
                          changes_ <= retention_.watch_events &&
                          geometry_bytes_ <= retention_.watch_bytes;
  return !is_exact && !is_watched;
}

std::size_t HistoryWindow::Shrink(std::int64_t now_ns) {
  std::size_t dropped = 0;
  for (; !entries_.empty() && IsOldestOut(now_ns); ++dropped) {
    const Entry& oldest = entries_.front();
    revisions_ -= oldest.changes > 0 ? 1 : 0;
    changes_ -= oldest.changes;
    geometry_bytes_ -= oldest.geometry_bytes;
    entries_.pop_front();
  }
  return dropped;
}

}  // namespace cwm::server
