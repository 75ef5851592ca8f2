#include "server/core/observations.h"

#include <algorithm>

namespace cwm::server {

void Observations::Mark(std::span<const Sighting> sightings,
                        std::chrono::system_clock::time_point when,
                        const collision::WorldSnapshot& world) {
  std::lock_guard lock(mutex_);
  for (const Sighting& sighting : sightings) {
    if (world.Find(sighting.name) == nullptr) continue;
    Record& record = records_[sighting.name];
    Observation& known = record.observation;
    if (sighting.anew || sighting.reachable.has_value()) known.reachable = sighting.reachable;
    if (known.last.has_value() && *known.last >= when) continue;  // scans may arrive out of order
    known.last = when;
    record.number = ++last_number_;
  }
}

void Observations::Forget(const std::string& name) {
  std::lock_guard lock(mutex_);
  records_.erase(name);
}

Observation Observations::Of(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = records_.find(name);
  return found == records_.end() ? Observation{} : found->second.observation;
}

std::uint64_t Observations::last_number() const {
  std::lock_guard lock(mutex_);
  return last_number_;
}

std::vector<Observations::Numbered> Observations::After(std::uint64_t number,
                                                        std::size_t most) const {
  std::vector<Numbered> after;
  {
    std::lock_guard lock(mutex_);
    if (last_number_ == number) return after;
    for (const auto& [name, record] : records_) {
      if (record.number > number) after.push_back({record.number, name, *record.observation.last});
    }
  }
  std::sort(after.begin(), after.end(),
            [](const Numbered& a, const Numbered& b) { return a.number < b.number; });
  if (after.size() > most) after.resize(most);
  return after;
}

}  // namespace cwm::server
