// The six guarantees of watches: ordered, unique, reliable, atomic, resumable, bookmarkable.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/fault/checker.h"
#include "tests/fault/history.h"
#include "tests/fault/world_log.h"

namespace cwm::fault {

// All messages of one revision.
struct WatchStep {
  WatchMessage::Kind kind = WatchMessage::Kind::kBookmark;
  std::int64_t revision = 0;
  std::int64_t time_ns = 0;  // of the last message
  std::vector<Effect> effects = {};
};

// The complete steps of a stream. A step that the stream did not finish is dropped: the client
// resumes before it. Adds violations of "atomic".
std::vector<WatchStep> StepsOf(const Watch& watch, Report& report);

// Follows the streams of each client through the restarts of the server, in the order of time, and
// compares what the client then knows with the logs.
void CheckWatches(const std::vector<Watch>& watches,
                  const std::map<std::string, WorldLog>& logs_by_uid, Report& report);

}  // namespace cwm::fault
