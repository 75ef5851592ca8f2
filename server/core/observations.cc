#include "server/core/observations.h"

#include <algorithm>

namespace cwm::server {

void Observations::Record(std::span<const Sighting> sightings,
                          std::chrono::system_clock::time_point when,
                          const collision::WorldSnapshot& world) {
  std::lock_guard lock(mutex_);
  for (const Sighting& sighting : sightings) {
    if (world.Find(sighting.name) == nullptr) continue;
    Entry& entry = entries_[sighting.name];
    Observation& known = entry.observation;
    if (sighting.is_new || sighting.reachable.has_value()) known.reachable = sighting.reachable;
    if (known.last.has_value() && *known.last >= when) continue;  // scans may arrive out of order
    known.last = when;
    entry.number = ++last_number_;
  }
}

void Observations::Forget(const std::string& name) {
  std::lock_guard lock(mutex_);
  entries_.erase(name);
}

Observation Observations::Get(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = entries_.find(name);
  return found == entries_.end() ? Observation{} : found->second.observation;
}

std::uint64_t Observations::last_number() const {
  std::lock_guard lock(mutex_);
  return last_number_;
}

std::vector<Observations::Numbered> Observations::NewerThan(std::uint64_t number,
                                                            std::size_t max_count) const {
  std::vector<Numbered> newer;
  {
    std::lock_guard lock(mutex_);
    if (last_number_ == number) return newer;
    for (const auto& [name, entry] : entries_) {
      if (entry.number > number) newer.push_back({entry.number, name, *entry.observation.last});
    }
  }
  std::sort(newer.begin(), newer.end(),
            [](const Numbered& a, const Numbered& b) { return a.number < b.number; });
  if (newer.size() > max_count) newer.resize(max_count);
  return newer;
}

}  // namespace cwm::server
