// Checks a history against what a durable server promises. Revisions are the total order of the
// writes of a world, so nothing is searched: the writes are folded once, in their order.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/fault/history.h"

namespace cwm::fault {

struct Violation {
  std::string rule;  // one of those in README.md
  std::string text;
};

struct Report {
  std::vector<Violation> violations = {};
  std::int64_t acknowledged = 0;  // writes and deletions
  std::int64_t refused = 0;
  std::int64_t unknown = 0;          // writes with an attempt that got no answer
  std::int64_t unknown_applied = 0;  // those of them that are in the world
  std::int64_t unresolved = 0;       // those that never got an answer
  std::int64_t lost = 0;             // acknowledged, and not there after a restart
  std::int64_t lost_observed = 0;    // states of robots that a power cut took, as it may
  std::int64_t revisions = 0;
  std::int64_t unchecked_revisions = 0;  // whose content no client saw whole
  std::int64_t reads = 0;                // compared with the fold
  std::int64_t watch_events = 0;         // compared with the fold
};

Report Check(const History& history);

}  // namespace cwm::fault
