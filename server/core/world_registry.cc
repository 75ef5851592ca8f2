#include "server/core/world_registry.h"

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <random>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/core/error.h"
#include "server/core/rule_expiry.h"

namespace cwm::server {
namespace {

constexpr char kDefaultName[] = "default";
constexpr std::size_t kMaxNameBytes = 128;  // fits into a file name with room for a suffix

absl::Status CheckName(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-' || c == '.';
  };
  if (name.size() <= kMaxNameBytes && std::all_of(name.begin(), name.end(), allowed)) {
    return absl::OkStatus();
  }
  return InvalidField("world",
                      absl::StrCat("is \"", name.substr(0, kMaxNameBytes), "\", must be 1 to ",
                                   kMaxNameBytes, " letters, digits or \"_-.\""));
}

// 128 random bits from the system, so that no two worlds of any server share a uid.
std::string RandomUid() {
  std::random_device bits;
  std::string uid;
  for (int i = 0; i < 4; ++i) absl::StrAppendFormat(&uid, "%08x", bits());
  return uid;
}

// Deletions by world and request_id, so that a retry gets the first reply although the world is
// gone.
class DeletionCache {
 public:
  explicit DeletionCache(const Retention& retention)
      : max_count_(retention.request_ids), retention_time_(retention.request_id_time) {}

  struct Key {
    std::string world;
    std::string request_id;
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  struct Record {
    std::string requested_uid;
    WorldRegistry::Deleted reply;
  };

  const Record* Find(const Key& key, Clock::time_point now) {
    while (!by_age_.empty() && by_age_.front().second + retention_time_ < now) DropOldest();
    const auto found = records_.find(key);
    return found == records_.end() ? nullptr : &found->second;
  }

  void Insert(const Key& key, Record record, Clock::time_point now) {
    if (static_cast<std::int64_t>(records_.size()) >= max_count_) DropOldest();
    records_[key] = std::move(record);
    by_age_.emplace_back(key, now);
  }

 private:
  void DropOldest() {
    records_.erase(by_age_.front().first);
    by_age_.pop_front();
  }

  const std::int64_t max_count_;
  const std::chrono::seconds retention_time_;
  std::map<Key, Record> records_;
  std::deque<std::pair<Key, Clock::time_point>> by_age_;  // oldest first
};

absl::Status Unknown(const std::string& name) {
  return MakeError(absl::StatusCode::kNotFound, absl::StrCat("world: there is no \"", name, "\""),
                   {.reason = "WORLD_UNKNOWN", .metadata = {{"world", name}}});
}

absl::Status ReusedForOtherWorld(const std::string& request_id) {
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("request_id: \"", request_id, "\" was used before for another world_uid"),
      {.reason = "REQUEST_ID_REUSED", .metadata = {{"request_id", request_id}}});
}

}  // namespace

const std::string& WorldNameOf(const std::string& name) {
  static const std::string& kDefault = *new std::string(kDefaultName);
  return name.empty() ? kDefault : name;
}

absl::Status WorldReplaced(const std::string& name, const std::string& expected_uid,
                           const std::string& actual_uid) {
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   absl::StrCat("world_uid: is \"", expected_uid, "\", the world \"", name,
                                "\" is now \"", actual_uid, "\""),
                   {.reason = "WORLD_REPLACED",
                    .metadata = {{"expected_uid", expected_uid}, {"actual_uid", actual_uid}}});
}

struct WorldRegistry::State {
  struct Entry {
    std::shared_ptr<World> world;
    bool committed = false;
    int leases = 0;
  };

  const Limits limits;
  const Retention retention;
  const std::function<Clock::time_point()> now;
  const std::shared_ptr<MemoryBudget> memory;
  const std::shared_ptr<RuleExpiry> expiry = std::make_shared<RuleExpiry>();
  mutable std::mutex mutex;
  std::map<std::string, Entry> entries;
  DeletionCache deletions;
  bool draining = false;
  Listener listener = {};
  std::atomic<Journal*> journal = nullptr;

  // Informs the listener. Must not be called under the mutex.
  void Notify(const World& world, WorldEvent event) {
    Listener current;
    {
      std::lock_guard lock(mutex);
      current = listener;
    }
    if (current) current(world, event);
  }

  // Under the mutex.
  absl::StatusOr<std::shared_ptr<World>> Find(const std::string& name,
                                              const std::string& uid) const {
    const auto found = entries.find(name);
    if (found == entries.end() || !found->second.committed) return Unknown(name);
    const std::shared_ptr<World>& world = found->second.world;
    if (!uid.empty() && uid != world->uid()) return WorldReplaced(name, uid, world->uid());
    return world;
  }

  void MakeVisible(const World& world) {
    {
      const std::lock_guard lock(mutex);
      Entry* const entry = EntryOf(world);
      if (entry == nullptr || entry->committed) return;
      entry->committed = true;
    }
    Notify(world, WorldEvent::kCreated);
  }

  void Remove(const World& world, const WorldDeletion& deletion) {
    {
      const std::lock_guard lock(mutex);
      if (EntryOf(world) != nullptr) entries.erase(world.name());
      if (!deletion.request_id.empty()) {
        deletions.Insert({world.name(), deletion.request_id},
                         {deletion.requested_uid, {world.uid(), world.Snapshot()->revision()}},
                         now());
      }
    }
    Notify(world, WorldEvent::kDeleted);
  }

  void DropHistories() {
    std::vector<std::shared_ptr<World>> worlds;
    {
      std::lock_guard lock(mutex);
      for (const auto& [name, entry] : entries) worlds.push_back(entry.world);
    }
    for (const std::shared_ptr<World>& world : worlds) world->DropHistory();
  }

  // Under the mutex. nullptr if the world was deleted meanwhile.
  Entry* EntryOf(const World& world) {
    const auto found = entries.find(world.name());
    return found == entries.end() || found->second.world.get() != &world ? nullptr : &found->second;
  }

  // Under the mutex.
  absl::StatusOr<Entry*> FindOrInsert(const std::string& name) {
    if (const auto found = entries.find(name); found != entries.end()) return &found->second;
    if (static_cast<std::int64_t>(entries.size()) >= limits.max_worlds) {
      return MakeError(absl::StatusCode::kResourceExhausted,
                       absl::StrCat("world: there are ", entries.size(), ", must be at most ",
                                    limits.max_worlds),
                       {.reason = "TOO_MANY_WORLDS",
                        .metadata = {{"limit", std::to_string(limits.max_worlds)}}});
    }
    auto world = std::make_shared<World>(name, RandomUid(), retention, now, Services());
    if (draining) world->Drain();
    return &(entries[name] = {.world = std::move(world), .committed = false, .leases = 0});
  }

  WorldServices Services() {
    return {.expiry = expiry,
            .memory = memory,
            .drop_histories = [this] { DropHistories(); },
            .max_objects = limits.max_objects,
            .max_pending_writes = limits.max_pending_writes,
            .journal = journal,
            .created = [this](const World& world) { MakeVisible(world); },
            .deleted = [this](const World& world,
                              const WorldDeletion& deletion) { Remove(world, deletion); }};
  }
};

WorldRegistry::Lease::Lease(Lease&& other) noexcept
    : state_(other.state_), world_(std::move(other.world_)) {}

WorldRegistry::Lease::~Lease() {
  if (world_ == nullptr) return;
  std::lock_guard lock(state_.mutex);
  State::Entry* const entry = state_.EntryOf(*world_);
  if (entry == nullptr) return;
  --entry->leases;
  if (!entry->committed && entry->leases == 0) state_.entries.erase(world_->name());
}

bool WorldRegistry::Lease::committed() const {
  std::lock_guard lock(state_.mutex);
  const State::Entry* const entry = state_.EntryOf(*world_);
  return entry != nullptr && entry->committed;
}

WorldRegistry::WorldRegistry(Limits limits, Retention retention,
                             std::shared_ptr<MemoryBudget> memory,
                             std::function<Clock::time_point()> now)
    : state_(new State{.limits = limits,
                       .retention = retention,
                       .now = std::move(now),
                       .memory = std::move(memory),
                       .mutex = {},
                       .entries = {},
                       .deletions = DeletionCache(retention)}) {}

// Somebody who still holds a world shares the expiry, whose destructor must not run in its own
// thread.
WorldRegistry::~WorldRegistry() { state_->expiry->Stop(); }

absl::StatusOr<WorldRegistry::Lease> WorldRegistry::AcquireLease(const std::string& name,
                                                                 const std::string& uid) {
  if (const absl::Status valid = CheckName(name); !valid.ok()) return valid;
  std::lock_guard lock(state_->mutex);
  if (!uid.empty()) {
    const auto found = state_->Find(WorldNameOf(name), uid);
    if (!found.ok()) return found.status();
  }
  const absl::StatusOr<State::Entry*> entry = state_->FindOrInsert(WorldNameOf(name));
  if (!entry.ok()) return entry.status();
  ++(*entry)->leases;
  return Lease(*state_, (*entry)->world);
}

absl::StatusOr<std::shared_ptr<World>> WorldRegistry::FindOrCreate(const std::string& name) {
  for (;;) {
    absl::StatusOr<Lease> lease = AcquireLease(name);
    if (!lease.ok()) return lease.status();
    if (lease->committed()) return lease->world();
    const auto nothing = [](const SnapshotPtr&) { return std::vector<collision::Change>(); };
    const absl::Status created = (*lease)->Update(nothing, {}).status();
    if (created.ok()) return lease->world();
    // Another call made the world and deleted it meanwhile: the next try makes a new one.
    if (!absl::IsNotFound(created)) return created;
  }
}

absl::StatusOr<std::shared_ptr<World>> WorldRegistry::Find(const std::string& name,
                                                           const std::string& uid) const {
  std::lock_guard lock(state_->mutex);
  return state_->Find(WorldNameOf(name), uid);
}

std::vector<std::shared_ptr<World>> WorldRegistry::List() const {
  std::lock_guard lock(state_->mutex);
  std::vector<std::shared_ptr<World>> worlds;
  worlds.reserve(state_->entries.size());
  for (const auto& [name, entry] : state_->entries) {
    if (entry.committed) worlds.push_back(entry.world);
  }
  return worlds;
}

absl::StatusOr<WorldRegistry::Deleted> WorldRegistry::Delete(const std::string& name,
                                                             const std::string& uid,
                                                             const std::string& request_id) {
  const DeletionCache::Key key{WorldNameOf(name), request_id};
  absl::StatusOr<std::shared_ptr<World>> world = absl::UnknownError("");
  {
    std::lock_guard lock(state_->mutex);
    if (const DeletionCache::Record* first = state_->deletions.Find(key, state_->now())) {
      if (first->requested_uid != uid) return ReusedForOtherWorld(request_id);
      return first->reply;
    }
    world = state_->Find(key.world, uid);
    if (!world.ok()) return world.status();
  }
  // Waits for the writer's turn and the journal, so it must not hold our lock. From then on the
  // world's revision is final.
  const auto closed = (*world)->Close({.requested_uid = uid, .request_id = request_id});
  if (closed.ok()) return Deleted{(*world)->uid(), *closed};
  if (!absl::IsNotFound(closed.status())) return closed.status();
  // Another call was faster; it may have been this one's first try.
  std::lock_guard lock(state_->mutex);
  const DeletionCache::Record* const first = state_->deletions.Find(key, state_->now());
  if (first != nullptr && first->requested_uid == uid) return first->reply;
  return Unknown(key.world);
}

void WorldRegistry::StopExpiry() { state_->expiry->Stop(); }

void WorldRegistry::SetJournal(Journal* journal) { state_->journal = journal; }
Journal* WorldRegistry::journal() const { return state_->journal; }

void WorldRegistry::Restore(std::vector<WorldImage> worlds,
                            std::span<const DeletedWorldImage> deleted) {
  for (WorldImage& image : worlds) {
    auto world = std::make_shared<World>(std::move(image), state_->retention, state_->now,
                                         state_->Services());
    world->ScheduleExpiry();
    const std::lock_guard lock(state_->mutex);
    state_->entries[world->name()] = {.world = world, .committed = true, .leases = 0};
  }
  const std::lock_guard lock(state_->mutex);
  for (const DeletedWorldImage& image : deleted) {
    if (image.deletion.request_id.empty()) continue;
    state_->deletions.Insert({image.name, image.deletion.request_id},
                             {image.deletion.requested_uid, {image.uid, image.revision}},
                             image.when);
  }
}

void WorldRegistry::SetListener(Listener listener) {
  std::lock_guard lock(state_->mutex);
  state_->listener = std::move(listener);
}

void WorldRegistry::Drain() {
  std::vector<std::shared_ptr<World>> worlds;
  {
    std::lock_guard lock(state_->mutex);
    state_->draining = true;
    for (const auto& [name, entry] : state_->entries) worlds.push_back(entry.world);
  }
  for (const std::shared_ptr<World>& world : worlds) world->Drain();
}

}  // namespace cwm::server
