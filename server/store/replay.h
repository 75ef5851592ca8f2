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

// chosen: the revisions that a world skips, and the numbers of names, after a loss of acknowledged
// records: more than the months since a backup make (2^32 are 49 days of one each millisecond).
// Records say how many they skip, so the numbers may change.
inline constexpr std::int64_t kRevisionsLostWithBackup = std::int64_t{1} << 32;
inline constexpr std::int64_t kNamesLostWithBackup = 1'000'000;

struct ReplayOptions {
  Retention retention = {};
  Limits limits = {};
  int threads = 0;  // 0: as many as there are cores
  ClockPair now = {};
  // Drops objects and robots whose content is missing or damaged, which is an error otherwise.
  bool accept_loss = false;
  // The account that the worlds are charged to, in any case; null: none.
  std::shared_ptr<MemoryBudget> memory = {};
  // Gets the share that is done, from 0 to 1, from any thread, one at a time.
  std::function<void(double share)> progress = {};
};

struct Replayed {
  std::vector<WorldImage> worlds = {};          // by name
  std::vector<DeletedWorldImage> deleted = {};  // of the time for which request ids are kept
  Compactor compactor;                          // was told of all records
  std::vector<std::string> warnings = {};       // what was lost; a clock that was set back
  std::int64_t record_count = 0;
  std::int64_t snapshot_count = 0;
  std::int64_t geometry_count = 0;  // distinct geometries that were prepared
  double seconds = 0;
};

// The worlds as they were after the newest record, with the past that `retention` keeps. After a
// power cut that may have taken observed records, each world skips revisions (kRevisionsLostAtMost)
// by a durable record without changes, which is appended here. Observed objects whose geometry a
// power cut took are removed in the same way, and their world keeps no past. After a loss of
// acknowledged records (Store::may_lack_durable) each world skips kRevisionsLostWithBackup
// revisions, and as many names as kNamesLostWithBackup says, and keeps no past. At last the store
// is told that it need not tell of the loss again.
//
// Allowances end by the wall clock, or by the newest record if the clock is behind it; those whose
// time is over are still in the images, due at once.
//
// DataLoss STORE_DAMAGED, with the place, for what the store should not hold; the errors of Store.
absl::StatusOr<Replayed> Replay(Store& store, const ReplayOptions& options);

}  // namespace cwm::server
