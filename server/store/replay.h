// Restores the worlds of a store when a server starts.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/world_image.h"
#include "server/store/compaction.h"
#include "server/store/decode_values.h"
#include "server/store/store.h"

namespace cwm::server {

struct ReplayOptions {
  Retention retention = {};
  Limits limits = {};
  int threads = 0;  // 0: as many as there are cores
  ClockPair now = {};
  // The account that the worlds are charged to, in any case; null: none.
  std::shared_ptr<MemoryBudget> memory = {};
  // Gets the share that is done, from 0 to 1, from any thread, one at a time.
  std::function<void(double share)> progress = {};
};

struct Replayed {
  std::vector<WorldImage> worlds = {};          // by name
  std::vector<DeletedWorldImage> deleted = {};  // of the time for which request ids are kept
  Compactor compactor;                          // was told of all records
  std::vector<std::string> warnings = {};       // objects that a power cut took
  std::int64_t record_count = 0;
  std::int64_t snapshot_count = 0;
  std::int64_t geometry_count = 0;  // distinct geometries that were prepared
  double seconds = 0;
};

// The worlds as they were after the newest record, with the past that `retention` keeps. After a
// power cut that may have taken observed records, each world skips revisions (kRevisionsLostAtMost)
// by a durable record without changes, which is appended here. Observed objects whose geometry a
// power cut took are removed in the same way, and their world keeps no past.
//
// DataLoss STORE_DAMAGED, with the place, for what the store should not hold; the errors of Store.
absl::StatusOr<Replayed> Replay(Store& store, const ReplayOptions& options);

}  // namespace cwm::server
