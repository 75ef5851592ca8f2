#include "server/core/observations.h"

#include <algorithm>

namespace cwm::server {

bool AddSighting(const Sighting& sighting, std::chrono::system_clock::time_point when,
                 Observation& known) {
  if (sighting.is_new || sighting.reachable.has_value()) known.reachable = sighting.reachable;
  if (known.last.has_value() && *known.last >= when) return false;
  known.last = when;
  return true;
}

void Observations::Record(std::span<const Sighting> sightings,
                          std::chrono::system_clock::time_point when,
                          const collision::WorldSnapshot& world) {
  std::lock_guard lock(mutex_);
  for (const Sighting& sighting : sightings) {
    if (world.Find(sighting.name) == nullptr) continue;
    Entry& entry = entries_[sighting.name];
    if (AddSighting(sighting, when, entry.observation)) entry.number = ++last_number_;
  }
}

void Observations::SetFacts(const std::string& name, const std::optional<SensorFacts>& facts,
                            const collision::WorldSnapshot& world) {
  std::lock_guard lock(mutex_);
  if (world.Find(name) == nullptr) return;
  Entry& entry = entries_[name];
  if (entry.observation.facts == facts) return;
  entry.observation.facts = facts;
  entry.facts_number = ++last_number_;
}

void Observations::Restore(const std::string& name, const Observation& observation) {
  std::lock_guard lock(mutex_);
  entries_[name] = {.observation = observation,
                    .number = observation.last.has_value() ? ++last_number_ : 0};
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

std::vector<Observations::NumberedFacts> Observations::FactsNewerThan(std::uint64_t number,
                                                                      std::size_t max_count) const {
  std::vector<NumberedFacts> newer;
  {
    std::lock_guard lock(mutex_);
    if (last_number_ == number) return newer;
    for (const auto& [name, entry] : entries_) {
      if (entry.facts_number <= number) continue;
      newer.push_back({entry.facts_number, name, entry.observation.facts});
    }
  }
  std::ranges::sort(newer, {}, &NumberedFacts::number);
  if (newer.size() > max_count) newer.resize(max_count);
  return newer;
}

}  // namespace cwm::server
