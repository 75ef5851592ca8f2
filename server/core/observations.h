// Reports of scans and of running sensors about a world's objects besides geometry and pose. Not a
// part of any revision.
#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "collision/world/world_snapshot.h"

namespace cwm::server {

// The facts of running sensors about an object; not kept over a restart.
struct SensorFacts {
  enum class Motion : std::uint8_t { kAtRest, kMoving, kSettling };
  enum class Visibility : std::uint8_t { kVisible, kOccluded, kStale, kLost };

  Motion motion = Motion::kAtRest;
  Visibility visibility = Visibility::kStale;
  bool identity_certain = true;  // false: it may have been swapped with another one of its shape
  std::string carried_by = {};   // "robot/link" that it moves with though it is not attached

  friend bool operator==(const SensorFacts&, const SensorFacts&) = default;
};

struct Observation {
  std::optional<std::chrono::system_clock::time_point> last;  // time of the last scan that saw it
  // For supports: true if a robot on the floor reaches them. Empty while the floor is not known.
  std::optional<bool> reachable;
  std::optional<SensorFacts> facts = {};  // empty: not followed by a running sensor
};

// The sighting of one object in one scan.
struct Sighting {
  std::string name;
  std::optional<bool> reachable = {};
  bool is_new = false;  // its geometry or pose is new, so earlier facts are void
};

// Adds a sighting in a scan taken at `when` to what is known of the object. True if it is newer
// than all before: scans may arrive out of order.
bool AddSighting(const Sighting& sighting, std::chrono::system_clock::time_point when,
                 Observation& known);

// Thread safe.
class Observations {
 public:
  // Ignores names that `world` does not contain.
  void Record(std::span<const Sighting> sightings, std::chrono::system_clock::time_point when,
              const collision::WorldSnapshot& world);
  // Sets the facts of an object; empty: it is no longer followed. Ignores names that `world` does
  // not contain.
  void SetFacts(const std::string& name, const std::optional<SensorFacts>& facts,
                const collision::WorldSnapshot& world);
  // Sets what was known of an object before a restart.
  void Restore(const std::string& name, const Observation& observation);
  void Forget(const std::string& name);
  Observation Get(const std::string& name) const;

  // Observations are numbered from 1 in the order in which they were made.
  struct Numbered {
    std::uint64_t number;
    std::string name;
    std::chrono::system_clock::time_point last;
  };
  std::uint64_t last_number() const;
  // The last observation of each object that is newer than `number`; oldest first, at most
  // `max_count`.
  std::vector<Numbered> NewerThan(std::uint64_t number, std::size_t max_count) const;

  // The facts that changed after `number`, likewise; their numbers are of the same sequence.
  struct NumberedFacts {
    std::uint64_t number;
    std::string name;
    std::optional<SensorFacts> facts;
  };
  std::vector<NumberedFacts> FactsNewerThan(std::uint64_t number, std::size_t max_count) const;

 private:
  struct Entry {
    Observation observation;
    std::uint64_t number = 0;        // of the last sighting
    std::uint64_t facts_number = 0;  // of the last change of the facts
  };
  mutable std::mutex mutex_;
  std::uint64_t last_number_ = 0;
  std::unordered_map<std::string, Entry> entries_;  // by object name
};

}  // namespace cwm::server
