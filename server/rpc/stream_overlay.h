// Hypothetical changes for the queries of a stream.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "cwm/v1/query.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Used by one query at a time.
class StreamOverlay {
 public:
  // Replaces the overlay, for the world that has the name now, or for the first one that gets it if
  // there is none yet. A list that cannot be read, or that was not read before the budget ended, is
  // refused now and again for each query that it concerns, so that no query is answered without it.
  // The client is charged for its memory: the errors of MemoryBudget::Charge.
  absl::Status Set(const Application& application, const v1::StreamOverlay& overlay,
                   const ClientId& client, WorkBudget* budget);

  // The snapshot for a query: `base` with the changes if they concern its world. Temporary
  // allowances of the changes are valid until they expire, whatever revision is queried.
  // WORLD_REPLACED if another world now has the name. The status of the budget if it ended.
  absl::StatusOr<SnapshotPtr> ApplyTo(const World& world, SnapshotPtr base, WorkBudget* budget);

 private:
  void Expire();

  std::string world_, world_uid_;  // the uid is empty while there is no such world
  absl::Status read_status_;
  std::vector<collision::Change> changes_;
  MemoryCharge charge_;         // for the geometry of the changes
  SnapshotPtr base_, changed_;  // of the last query, since most query the same revision
};

// `base` with the changes; an error names the list by the path of its field.
absl::StatusOr<SnapshotPtr> WithChanges(const SnapshotPtr& base,
                                        const std::vector<collision::Change>& changes,
                                        const std::string& list, WorkBudget* budget);

}  // namespace cwm::server
