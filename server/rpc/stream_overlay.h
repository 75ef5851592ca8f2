// What if, for the questions of a stream.
#pragma once

#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "cwm/v1/query.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Used by one question at a time.
class StreamOverlay {
 public:
  // The overlay holds from now on, for the world that has the name now or, where none has, first
  // has it. A list that cannot be read is refused now, and to each question that it is about: none
  // is answered as if nobody had asked what if. So is one that was not read before the budget
  // ended. The client is charged for what it holds: the errors of MemoryBudget::Charge.
  absl::Status Set(const Application& application, const v1::StreamOverlay& overlay,
                   const ClientId& client, WorkBudget* budget);

  // The world that a question is asked of: `base` with the changes, where they are about it.
  // Collisions that the changes allow for a time are allowed until it ends, whatever revision is
  // asked. WORLD_REPLACED of another world under that name. The status of the budget where it
  // ended.
  absl::StatusOr<SnapshotPtr> Over(const World& world, SnapshotPtr base, WorkBudget* budget);

 private:
  void Expire();

  std::string world_, world_uid_;  // the uid empty while there is no such world
  absl::Status legible_;
  std::vector<collision::Change> changes_;
  MemoryCharge charge_;         // of their geometry
  SnapshotPtr base_, changed_;  // of the last question: most ask the same revision
};

// `base` with the changes; a refusal names the list by the path of its field.
absl::StatusOr<SnapshotPtr> WithChanges(const SnapshotPtr& base,
                                        const std::vector<collision::Change>& changes,
                                        const std::string& list, WorkBudget* budget);

}  // namespace cwm::server
