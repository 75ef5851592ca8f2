// The newest records of a world, which are kept one by one: older ones are folded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>

#include "server/core/limits.h"

namespace cwm::server {

// The records behind the exact snapshots and the watches that a world may have to restore
// (Retention). A record leaves the window when it is needed for neither.
class HistoryWindow {
 public:
  struct Entry {
    std::int64_t when_ns = 0;         // of the Unix epoch
    std::int64_t changes = 0;         // 0: it makes no revision
    std::int64_t geometry_bytes = 0;  // about so many are kept for it alone
  };

  explicit HistoryWindow(const Retention& retention) : retention_(retention) {}

  void Add(const Entry& entry);
  // Drops the records that are no longer in the window; returns their number.
  std::size_t Shrink(std::int64_t now_ns);
  std::size_t size() const { return entries_.size(); }

 private:
  bool IsOldestOut(std::int64_t now_ns) const;

  Retention retention_;
  std::deque<Entry> entries_;                                      // oldest first
  std::int64_t revisions_ = 0, changes_ = 0, geometry_bytes_ = 0;  // of all entries
};

}  // namespace cwm::server
