// A world as it is restored after a restart.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/core/history.h"
#include "server/core/journal.h"
#include "server/core/memory_budget.h"
#include "server/core/write_facts.h"

namespace cwm::server {

struct WorldImage {
  std::string name;
  std::string uid;
  // The account to which its geometry is charged; absent: a new one.
  std::optional<MemoryBudget::Payer> payer = {};
  // The kept events up to `base`, oldest first, for watches: their snapshots are no longer kept.
  // The first was applied to `oldest_watch`, each other one to the result of the one before.
  std::vector<EventPtr> earlier = {};
  collision::Revision oldest_watch = {};  // that of `base` if there are no earlier events
  SnapshotPtr base;                       // at the oldest revision whose snapshot is kept
  struct Step {
    EventPtr event;
    SnapshotPtr next;
  };
  std::vector<Step> steps = {};  // the kept revisions after it; numbers may be missing between two
  struct Request {
    WrittenRequest request;
    collision::Revision revision;
    Clock::time_point when;
  };
  std::vector<Request> requests = {};                     // oldest first
  std::map<std::string, std::int64_t> last_numbers = {};  // of names, by stem
  std::map<std::string, SensorPose> sensor_poses = {};    // by sensor
  struct Observed {
    std::string name;
    Observation observation;
  };
  std::vector<Observed> observations = {};  // in the order in which they were made
};

// A world that was deleted a short time ago, for retries of its deletion.
struct DeletedWorldImage {
  std::string name;
  std::string uid;
  collision::Revision revision;  // its last
  WorldDeletion deletion;
  Clock::time_point when;
};

}  // namespace cwm::server
