#include "server/store/replay.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <thread>
#include <unordered_map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/store/decode_fault.h"
#include "server/store/encode_entry.h"
#include "server/store/history_window.h"
#include "server/store/stored_world.h"
#include "server/store/world_images.h"

namespace cwm::server {
namespace {

// chosen: large enough that a disk reads at its full rate.
constexpr std::int64_t kBytesAtOnce = 8 << 20;
// measured: the share of reading and folding in a replay of 10,000 objects of 100 triangles and
// 100,000 moves.
constexpr double kRead = 0.2;

// One world while its records are read.
struct Reading {
  Reading(WorldFold fold, const Retention& retention) : world(std::move(fold)), window(retention) {}
  FoldedWorld world;
  HistoryWindow window;       // of the world's events
  std::int64_t sequence = 0;  // of its snapshot
};

class Replayer {
 public:
  Replayer(Store& store, const ReplayOptions& options)
      : store_(store),
        options_(options),
        threads_(options.threads > 0
                     ? options.threads
                     : std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {
    replayed_.compactor = Compactor(options.retention);
  }

  absl::StatusOr<Replayed> Run() {
    const auto begin = std::chrono::steady_clock::now();
    absl::Status status = ReadSnapshots();
    if (status.ok()) status = ReadRecords();
    if (status.ok()) status = MakeImages();
    if (status.ok()) status = AppendSkips();
    if (status.ok()) status = EndRecovery();
    if (!status.ok()) return status;
    replayed_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(replayed_);
  }

 private:
  // The lost parts of a world.
  struct Losses {
    std::vector<std::string> objects = {}, robots = {};
    std::vector<store::v1::Object> detached_objects = {};
    bool drops_past = false;
  };

  void Report(double share) const {
    if (options_.progress) options_.progress(share);
  }

  absl::Status ReadSnapshots() {
    absl::StatusOr<std::vector<StoredSnapshot>> snapshots = store_.Snapshots();
    if (!snapshots.ok()) return snapshots.status();
    for (StoredSnapshot& stored : *snapshots) {
      absl::StatusOr<WorldFold> fold = FoldOf(stored, options_.retention);
      if (!fold.ok()) return fold.status();
      stored.payload = {};
      auto reading = std::make_unique<Reading>(*std::move(fold), options_.retention);
      reading->sequence = stored.sequence;
      if (!worlds_.emplace(stored.world_uid, std::move(reading)).second) {
        return Damaged(absl::StrCat("world ", stored.world_uid), "has two snapshots");
      }
      ++replayed_.snapshot_count;
    }
    return absl::OkStatus();
  }

  absl::Status ReadRecords() {
    const std::int64_t last = store_.last_sequence();
    for (std::int64_t sequence = 0; sequence < last;) {
      const auto records = store_.Follow("", sequence, kBytesAtOnce);
      if (!records.ok()) return records.status();
      if (records->empty()) break;  // the last ones were folded
      for (const StoredRecord& stored : *records) {
        if (absl::Status status = Take(stored); !status.ok()) return status;
      }
      sequence = records->back().sequence;
      Report(kRead * static_cast<double>(sequence) / static_cast<double>(last));
    }
    return absl::OkStatus();
  }

  absl::Status Take(const StoredRecord& stored) {
    std::unique_ptr<Reading>& reading = worlds_[stored.world_uid];
    if (reading == nullptr) {
      reading = std::make_unique<Reading>(WorldFold(options_.retention), options_.retention);
    }
    if (stored.sequence <= reading->sequence) return absl::OkStatus();
    absl::StatusOr<store::v1::Record> record = ParseRecord(stored);
    if (!record.ok()) return record.status();
    Compactor::Logged logged{.world_uid = stored.world_uid,
                             .sequence = stored.sequence,
                             .when_ns = record->when_ns(),
                             .bytes = static_cast<std::int64_t>(stored.payload.size()),
                             .is_deletion = record->has_deletion()};
    absl::StatusOr<std::optional<FoldedEvent>> event =
        reading->world.fold.Apply(*std::move(record));
    if (!event.ok()) return DamagedAt(PlaceOf(stored), event.status());
    if (event->has_value()) {
      logged.changes = (*event)->size();
      logged.drops_past = (*event)->drops_past;
      KeepEvent(**std::move(event), *reading);
    }
    replayed_.compactor.Add(logged);
    ++replayed_.record_count;
    return absl::OkStatus();
  }

  void KeepEvent(FoldedEvent event, Reading& reading) const {
    if (event.drops_past) {
      reading.window = HistoryWindow(options_.retention);
      reading.world.events.clear();
      return;
    }
    reading.window.Add({.when_ns = event.when_ns,
                        .changes = event.size(),
                        .geometry_bytes = event.superseded_bytes()});
    reading.world.events.push_back(std::move(event));
    const std::size_t left = reading.window.Shrink(NanosecondsOf(options_.now.wall));
    for (std::size_t i = 0; i < left; ++i) reading.world.events.pop_front();
  }

  absl::Status MakeImages() {
    std::vector<FoldedWorld> living;
    const ClockPair rules_clock = RulesClock();
    for (auto& [uid, reading] : worlds_) {
      if (reading->world.fold.end()) {
        AddDeleted(reading->world.fold);
      } else {
        living.push_back(std::move(reading->world));
      }
    }
    worlds_.clear();
    std::ranges::sort(replayed_.deleted, {}, &DeletedWorldImage::when);
    const auto name_of = [](const FoldedWorld& world) { return world.fold.name(); };
    std::ranges::sort(living, {}, name_of);
    const auto twice = std::ranges::adjacent_find(living, {}, name_of);
    if (twice != living.end()) {
      return Damaged(absl::StrCat("world '", twice->fold.name(), "'"), "is there twice");
    }
    absl::StatusOr<MadeWorlds> made = MakeWorlds(
        store_, std::move(living),
        {.retention = options_.retention,
         .robot_limits = options_.limits.robot,
         .threads = threads_,
         .now = options_.now,
         .rules_clock = rules_clock,
         .accepted = {.observed = store_.may_lack_observed() || store_.may_lack_durable(),
                      .all = options_.accept_loss},
         .memory = options_.memory,
         .progress = [this](double share) { Report(kRead + (1 - kRead) * share); }});
    if (!made.ok()) return made.status();
    replayed_.geometry_count = made->geometry_count;
    for (MadeWorld& world : made->worlds) {
      const std::string place = absl::StrCat("world '", world.image.name, "': ");
      for (const std::string& object : world.lost_objects) {
        replayed_.warnings.push_back(
            absl::StrCat(place, "object '", object,
                         "' is gone: its geometry is not, or no longer, on the disk"));
      }
      for (const std::string& robot : world.lost_robots) {
        replayed_.warnings.push_back(
            absl::StrCat(place, "robot '", robot, "' is gone: its files are missing or damaged"));
      }
      losses_.push_back({.objects = std::move(world.lost_objects),
                         .robots = std::move(world.lost_robots),
                         .detached_objects = std::move(world.detached_objects),
                         .drops_past = world.has_losses || store_.may_lack_durable()});
      replayed_.worlds.push_back(std::move(world.image));
    }
    return absl::OkStatus();
  }

  // The clock by which allowances end. Warns if the wall clock is behind the newest record.
  ClockPair RulesClock() {
    std::int64_t newest_ns = NanosecondsOf(options_.now.wall);
    for (const auto& [uid, reading] : worlds_) {
      newest_ns = std::max(newest_ns, reading->world.fold.newest_when_ns());
    }
    const collision::WallTime newest = WallTimeOf(newest_ns);
    const auto behind = newest - options_.now.wall;
    if (behind > std::chrono::seconds(1)) {
      replayed_.warnings.push_back(absl::StrCat(
          "the clock is ", std::chrono::duration_cast<std::chrono::seconds>(behind).count(),
          " s behind the newest record: allowances end by the time of that record"));
    }
    return {.steady = options_.now.steady, .wall = newest};
  }

  void AddDeleted(const WorldFold& fold) {
    const WorldFold::End& end = *fold.end();
    const Clock::time_point when = SteadyTimeOf(end.when_ns, options_.now);
    if (when + options_.retention.request_id_time < options_.now.steady) return;
    replayed_.deleted.push_back({.name = fold.name(),
                                 .uid = fold.uid(),
                                 .revision = {fold.state().revision},
                                 .deletion = {.requested_uid = end.deletion.requested_uid(),
                                              .request_id = end.deletion.request_id()},
                                 .when = when});
  }

  // The revisions that a loss may have taken are never made again, nor are the names.
  absl::Status AppendSkips() {
    const bool may_lack_durable = store_.may_lack_durable();
    const std::int64_t skipped = may_lack_durable ? kRevisionsLostWithBackup : kRevisionsLostAtMost;
    std::vector<StoredRecord> records;
    std::vector<bool> drops_past;  // of each record
    for (std::size_t i = 0; i < replayed_.worlds.size(); ++i) {
      const Losses& losses = losses_[i];
      if (!store_.may_lack_observed() && !losses.drops_past) continue;
      WorldImage& image = replayed_.worlds[i];
      const SnapshotPtr latest = image.steps.empty() ? image.base : image.steps.back().next;
      const collision::Revision revision{latest->revision().value + skipped};
      if (may_lack_durable) RaiseNumbers(image);
      records.push_back(SkipOf(image, revision, skipped - 1, losses));
      drops_past.push_back(losses.drops_past);
      auto event = std::make_shared<Event>();
      event->revision = revision;
      event->when = options_.now.steady;
      auto next = std::make_shared<const collision::WorldSnapshot>(latest->After(revision, {}));
      if (!losses.drops_past) {
        image.steps.push_back({.event = std::move(event), .next = std::move(next)});
      } else {  // nobody may resume from a revision that had what is lost
        image.earlier.clear();
        image.steps.clear();
        image.base = std::move(next);
        image.oldest_watch = revision;
      }
    }
    if (records.empty()) return absl::OkStatus();
    absl::StatusOr<AppendResult> result = store_.Append(records, Durability::kDurable);
    if (absl::IsResourceExhausted(result.status())) {
      store_.CheckRoom().IgnoreError();  // makes some
      result = store_.Append(records, Durability::kDurable);
    }
    if (!result.ok()) return result.status();
    if (*result != AppendResult::kDurable) {
      return absl::UnavailableError("another server appended to the store while it was read");
    }
    for (std::size_t i = 0; i < records.size(); ++i) {
      const StoredRecord& record = records[i];
      replayed_.compactor.Add({.world_uid = record.world_uid,
                               .sequence = record.sequence,
                               .when_ns = NanosecondsOf(options_.now.wall),
                               .bytes = static_cast<std::int64_t>(record.payload.size()),
                               .drops_past = drops_past[i]});
    }
    return absl::OkStatus();
  }

  // From now on the store need not tell of the loss.
  absl::Status EndRecovery() {
    if (!store_.may_lack_observed() && !store_.may_lack_durable()) return absl::OkStatus();
    absl::Status status = store_.RecoveryDone();
    if (!absl::IsResourceExhausted(status)) return status;
    store_.CheckRoom().IgnoreError();  // makes some
    return store_.RecoveryDone();
  }

  // So that no name is given again to something else.
  static void RaiseNumbers(WorldImage& image) {
    constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max() - kNamesLostWithBackup;
    for (auto& [stem, number] : image.last_numbers) {
      number = std::min(number, kMax) + kNamesLostWithBackup;
    }
  }

  StoredRecord SkipOf(const WorldImage& image, collision::Revision revision, std::int64_t skipped,
                      const Losses& losses) {
    store::v1::Record record;
    record.set_world_uid(image.uid);
    record.set_revision(revision.value);
    record.set_when_ns(NanosecondsOf(options_.now.wall));
    store::v1::Write& write = *record.mutable_write();
    write.set_makes_revision(true);
    write.set_skipped_revisions(skipped);
    write.set_drops_past(losses.drops_past);
    for (const std::string& name : losses.objects) write.add_objects()->set_name(name);
    for (const store::v1::Object& object : losses.detached_objects) {
      store::v1::ObjectChange& change = *write.add_objects();
      change.set_name(object.name());
      *change.mutable_after() = object;
    }
    for (const std::string& name : losses.robots) write.add_robots()->set_name(name);
    if (store_.may_lack_durable()) {
      for (const auto& [stem, number] : image.last_numbers) {
        store::v1::LastNumber& last = *write.add_last_numbers();
        last.set_stem(stem);
        last.set_number(number);
      }
    }
    const std::int64_t last = std::max(store_.last_sequence(), last_skip_);
    last_skip_ = last + 1;
    return {.sequence = last_skip_,
            .epoch = store_.epoch(),
            .world_uid = image.uid,
            .revision = revision.value,
            .payload = record.SerializeAsString()};
  }

  Store& store_;
  const ReplayOptions& options_;
  const int threads_;
  std::unordered_map<std::string, std::unique_ptr<Reading>> worlds_;  // by uid
  std::vector<Losses> losses_;                                        // of each world of the result
  std::int64_t last_skip_ = 0;  // the sequence of the last skip
  Replayed replayed_;
};

}  // namespace

absl::StatusOr<Replayed> Replay(Store& store, const ReplayOptions& options) {
  return Replayer(store, options).Run();
}

}  // namespace cwm::server
