#include "server/core/history.h"

#include <algorithm>
#include <map>
#include <string>
#include <type_traits>
#include <utility>

#include "server/core/approximate_bytes.h"

namespace cwm::server {

using collision::ObjectDelta;
using collision::Revision;

History::History(Retention retention, SnapshotPtr first, MemoryCharge charge)
    : retention_(retention), snapshots_(retention, std::move(first)), charge_(std::move(charge)) {
  UpdateCharge();
}

void History::RestoreEvents(std::span<const EventPtr> events, Revision from) {
  for (const EventPtr& event : events) {
    AddEvent(event, from);
    from = event->revision;
  }
  UpdateCharge();
}

std::int64_t History::SupersededBytes(const Event& event) {
  return ApproximateSupersededBytes(event.deltas) + ApproximateSupersededBytes(event.robot_deltas);
}

void History::AddEvent(EventPtr event, Revision before) {
  static_assert(sizeof(collision::RobotDelta) == sizeof(ObjectDelta));
  const std::int64_t deltas = event->size();
  const std::int64_t own_bytes = static_cast<std::int64_t>(sizeof(Event)) +
                                 ApproximateBytes(event->rule_deltas) +
                                 deltas * static_cast<std::int64_t>(sizeof(ObjectDelta));
  const std::int64_t bytes = own_bytes + SupersededBytes(*event);
  event_bytes_ += bytes;
  event_deltas_ += deltas;
  own_event_bytes_ += own_bytes;
  events_.push_back({std::move(event), before, own_bytes, bytes});
}

History::Dropped History::Append(SnapshotPtr next, EventPtr event) {
  const Revision before = latest();
  const Clock::time_point now = event->when;
  const KeptSnapshots::Cost cost{.changed_count = event->deltas.size() + event->robot_deltas.size(),
                                 .superseded_bytes = SupersededBytes(*event)};
  Dropped dropped;
  snapshots_.Append(std::move(next), now, cost, dropped.snapshots);
  AddEvent(std::move(event), before);
  ExpireEvents(now, dropped);
  ShrinkEvents(dropped);
  UpdateCharge();
  return dropped;
}

History::Dropped History::Expire(Clock::time_point now) {
  Dropped dropped;
  ExpireEvents(now, dropped);
  snapshots_.EndLeases(now, dropped.snapshots);
  UpdateCharge();
  return dropped;
}

void History::ExpireEvents(Clock::time_point now, Dropped& dropped) {
  while (!events_.empty() && events_.front().event->when + retention_.watch_time < now) {
    DropOldestEvent(dropped);
  }
}

History::Dropped History::DropHistory() {
  Dropped dropped;
  snapshots_.DropAllButLatest(dropped.snapshots);
  while (events_.size() > 1) DropOldestEvent(dropped);
  UpdateCharge();
  return dropped;
}

void History::ShrinkEvents(Dropped& dropped) {
  while (events_.size() > 1 &&
         (event_deltas_ > retention_.watch_events || event_bytes_ > retention_.watch_bytes)) {
    DropOldestEvent(dropped);
  }
}

void History::DropOldestEvent(Dropped& dropped) {
  event_bytes_ -= events_.front().bytes;
  own_event_bytes_ -= events_.front().own_bytes;
  event_deltas_ -= events_.front().event->size();
  dropped.events.push_back(std::move(events_.front().event));
  events_.pop_front();
}

Revision History::oldest_watch() const {
  return events_.empty() ? latest() : events_.front().before;
}

bool History::WasMade(Revision revision) const {
  if (revision >= latest()) return revision == latest();
  return revision < oldest_watch() || EventFrom(revision) != nullptr;
}

EventPtr History::EventFrom(Revision revision) const {
  const auto found = std::ranges::lower_bound(events_, revision, {}, &KeptEvent::before);
  return found == events_.end() || found->before != revision ? nullptr : found->event;
}

std::vector<EventPtr> History::EventsAfter(Revision revision) const {
  std::vector<EventPtr> events;
  auto kept = std::ranges::lower_bound(events_, revision, {}, &KeptEvent::before);
  for (; kept != events_.end(); ++kept) events.push_back(kept->event);
  return events;
}

namespace {

// The members of a world, by name.
template <class Ptr>
using ByName = std::map<std::string, Ptr>;

template <class Members>
auto ByNameOf(const Members& members) {
  ByName<std::decay_t<decltype(*members.begin())>> by_name;
  for (const auto& member : members) by_name[member->name] = member;
  return by_name;
}

// Undoes the deltas in reverse order, since a member that was made anew is a removal followed by an
// addition.
template <class Deltas, class Ptr>
void UndoDeltas(const Deltas& deltas, ByName<Ptr>& by_name) {
  for (auto delta = deltas.rbegin(); delta != deltas.rend(); ++delta) {
    if (delta->before == nullptr) {
      by_name.erase(delta->after->name);
    } else {
      by_name[delta->before->name] = delta->before;
    }
  }
}

template <class Ptr>
std::vector<Ptr> InOrder(const ByName<Ptr>& by_name) {
  std::vector<Ptr> members;
  members.reserve(by_name.size());
  for (const auto& [name, member] : by_name) members.push_back(member);
  return members;
}

}  // namespace

SnapshotPtr UndoEvents(const collision::WorldSnapshot& latest, const std::vector<EventPtr>& events,
                       Revision revision) {
  auto objects = ByNameOf(latest.objects());
  auto robots = ByNameOf(latest.robots());
  collision::PairRules rules = latest.pair_rules();
  for (auto event = events.rbegin(); event != events.rend(); ++event) {
    UndoDeltas((*event)->deltas, objects);
    UndoDeltas((*event)->robot_deltas, robots);
    for (const collision::PairRuleDelta& delta : (*event)->rule_deltas) {
      SetRule(rules, delta.before);
    }
  }
  return std::make_shared<const collision::WorldSnapshot>(revision, InOrder(objects),
                                                          InOrder(robots), std::move(rules));
}

}  // namespace cwm::server
