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
  // Holds from now on. A list that cannot be read is refused now, and to each question that it is
  // about: none is answered as if nobody had asked what if.
  absl::Status Set(const Application& application, const v1::StreamOverlay& overlay);

  // What is asked of the world: `base` with the changes, where they are about it.
  absl::StatusOr<SnapshotPtr> Over(const World& world, SnapshotPtr base);

 private:
  std::string world_;
  absl::Status legible_;
  std::vector<collision::Change> changes_;
  SnapshotPtr base_, changed_;  // of the last question: most ask the same revision
};

// `base` with the changes; a refusal names the list by the path of its field.
absl::StatusOr<SnapshotPtr> WithChanges(const SnapshotPtr& base,
                                        const std::vector<collision::Change>& changes,
                                        const std::string& list);

}  // namespace cwm::server
