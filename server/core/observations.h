// What scans told of a world's objects beside their geometry and pose: no part of any revision.
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

struct Observation {
  std::optional<std::chrono::system_clock::time_point> last;  // of a scan that saw it
  // Of supports: whether a robot on the floor reaches them. Nothing while the floor is not known.
  std::optional<bool> reachable;
};

// One object in one scan.
struct Sighting {
  std::string name;
  std::optional<bool> reachable = {};
  bool anew = false;  // its geometry or pose is new: what was known of it holds no more
};

// Thread safe.
class Observations {
 public:
  // Names that `world` does not hold are left out.
  void Mark(std::span<const Sighting> sightings, std::chrono::system_clock::time_point when,
            const collision::WorldSnapshot& world);
  void Forget(const std::string& name);
  Observation Of(const std::string& name) const;

  // Observations are numbered from 1 in the order in which they were made.
  struct Numbered {
    std::uint64_t number;
    std::string name;
    std::chrono::system_clock::time_point last;
  };
  std::uint64_t last_number() const;
  // Those after `number`, the last one of each object; oldest first, at most `most`.
  std::vector<Numbered> After(std::uint64_t number, std::size_t most) const;

 private:
  struct Record {
    Observation observation;
    std::uint64_t number = 0;
  };
  mutable std::mutex mutex_;
  std::uint64_t last_number_ = 0;
  std::unordered_map<std::string, Record> records_;  // by object name
};

}  // namespace cwm::server
