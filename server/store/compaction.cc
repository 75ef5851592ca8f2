#include "server/store/compaction.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/store/decode_fault.h"
#include "server/store/encode_entry.h"
#include "server/store/stored_world.h"

namespace cwm::server {
namespace {

// chosen: a millisecond or two of reading and folding.
constexpr std::int64_t kBytesOfStep = 256 << 10;

}  // namespace

Compaction::Compaction(std::string world_uid, std::int64_t up_to, const Retention& retention,
                       std::int64_t max_snapshot_bytes)
    : world_uid_(std::move(world_uid)),
      up_to_(up_to),
      retention_(retention),
      max_snapshot_bytes_(max_snapshot_bytes),
      fold_(retention) {}

absl::Status Compaction::Step(Store& store) {
  switch (stage_) {
    case Stage::kReadSnapshot:
      return ReadSnapshot(store);
    case Stage::kReadRecords:
      return ReadRecords(store);
    case Stage::kAddObjects:
      return AddObjects(store);
    case Stage::kPutSnapshot:
      return PutSnapshot(store);
    case Stage::kDone:
      break;
  }
  return absl::OkStatus();
}

absl::Status Compaction::ReadSnapshot(Store& store) {
  const absl::StatusOr<std::optional<StoredSnapshot>> stored = store.SnapshotOf(world_uid_);
  if (!stored.ok()) return stored.status();
  if (stored->has_value()) {
    absl::StatusOr<WorldFold> fold = FoldOf(**stored, retention_);
    if (!fold.ok()) return fold.status();
    fold_ = *std::move(fold);
    sequence_ = (*stored)->sequence;
  }
  stage_ = sequence_ >= up_to_ ? Stage::kDone : Stage::kReadRecords;
  return absl::OkStatus();
}

absl::Status Compaction::ReadRecords(Store& store) {
  const auto records = store.Follow(world_uid_, sequence_, kBytesOfStep);
  if (!records.ok()) return records.status();
  for (const StoredRecord& stored : *records) {
    if (stored.sequence > up_to_) break;
    absl::StatusOr<store::v1::Record> record = ParseRecord(stored);
    if (!record.ok()) return record.status();
    const auto event = fold_.Apply(*std::move(record));
    if (!event.ok()) return DamagedAt(PlaceOf(stored), event.status());
    sequence_ = stored.sequence;
  }
  if (records->empty()) return Damaged(absl::StrCat("record ", up_to_), "is missing");
  if (sequence_ == up_to_) return BeginSnapshot(store);
  if (records->back().sequence > up_to_) {
    return Damaged(absl::StrCat("record ", up_to_), "is missing");
  }
  return absl::OkStatus();
}

absl::Status Compaction::BeginSnapshot(const Store& store) {
  snapshot_.sequence = sequence_;
  snapshot_.world_uid = world_uid_;
  snapshot_.revision = fold_.state().revision;
  objects_ = fold_.ObjectsInOrder();
  const absl::Status status = Append(fold_.SnapshotWithoutObjects(), store);
  fold_ = WorldFold(retention_);
  stage_ = Stage::kAddObjects;
  return status;
}

absl::Status Compaction::AddObjects(const Store& store) {
  const std::size_t end = snapshot_.payload.size() + static_cast<std::size_t>(kBytesOfStep);
  while (added_objects_ < objects_.size() && snapshot_.payload.size() < end) {
    store::v1::WorldSnapshot part;
    AddObject(*objects_[added_objects_++], part);
    if (absl::Status status = Append(part, store); !status.ok()) return status;
  }
  if (static_cast<std::int64_t>(snapshot_.payload.size()) > max_snapshot_bytes_) {
    GiveUp();
    return absl::OkStatus();
  }
  if (added_objects_ == objects_.size()) stage_ = Stage::kPutSnapshot;
  return absl::OkStatus();
}

// Parts of a message, one behind the other, are the message.
absl::Status Compaction::Append(const store::v1::WorldSnapshot& part, const Store& store) {
  part.AppendToString(&snapshot_.payload);
  return AddBlobs(part, store, blobs_);
}

absl::Status Compaction::PutSnapshot(Store& store) {
  snapshot_.blobs.assign(blobs_.begin(), blobs_.end());
  const absl::Status status = store.PutSnapshot(snapshot_);
  if (DetailsOf(status).reason == "SNAPSHOT_TOO_LARGE") {
    GiveUp();
    return absl::OkStatus();
  }
  if (status.ok()) stage_ = Stage::kDone;
  return status;
}

void Compaction::GiveUp() {
  is_too_large_ = true;
  stage_ = Stage::kDone;
}

Compactor::Logged Compactor::LoggedOf(const JournalEntry& entry) {
  Logged record{.world_uid = entry.world_uid,
                .when_ns = NanosecondsOf(entry.when),
                .is_deletion = std::holds_alternative<WorldDeletion>(entry.what)};
  const auto* const write = std::get_if<WorldWrite>(&entry.what);
  if (write != nullptr && write->event != nullptr) record.changes = write->event->size();
  return record;
}

void Compactor::Add(const Logged& record) {
  if (record.is_deletion) {
    logs_.erase(record.world_uid);
    deleted_.push_back(
        {.world_uid = record.world_uid, .sequence = record.sequence, .when_ns = record.when_ns});
    return;
  }
  const auto [found, is_new] =
      logs_.try_emplace(record.world_uid, Log{.window = HistoryWindow(retention_),
                                              .max_records = limits_.max_records,
                                              .max_bytes = limits_.max_bytes});
  Log& log = found->second;
  log.window.Add({.when_ns = record.when_ns, .changes = record.changes});
  log.kept.push_back({.sequence = record.sequence, .bytes = record.bytes});
  for (std::size_t left = log.window.Shrink(record.when_ns); left > 0; --left) LeaveWindow(log);
  if (record.drops_past) {
    log.window = HistoryWindow(retention_);
    while (!log.kept.empty()) LeaveWindow(log);
  }
  if (!IsLong(log) || log.is_due) return;
  log.is_due = true;
  due_.push_back(record.world_uid);
}

bool Compactor::IsLong(const Log& log) {
  return log.old_records > log.max_records || log.old_bytes > log.max_bytes;
}

void Compactor::LeaveWindow(Log& log) {
  ++log.old_records;
  log.old_bytes += log.kept.front().bytes;
  log.old_sequence = log.kept.front().sequence;
  log.kept.pop_front();
}

bool Compactor::MayDrop(const Deleted& deleted, collision::WallTime now) const {
  const std::chrono::nanoseconds kept = retention_.request_id_time;
  // Divided, so that no clock of a damaged store overflows.
  return deleted.when_ns / 2 < NanosecondsOf(now) / 2 - kept.count() / 2;
}

// A clock that was set back ends the pause.
bool Compactor::IsPaused(collision::WallTime now) const {
  return full_since_ && now >= *full_since_ && now - *full_since_ < kWaitWhenFull;
}

bool Compactor::IsDue(collision::WallTime now) const {
  if (IsPaused(now)) return false;
  return current_ != nullptr || !due_.empty() ||
         (!deleted_.empty() && MayDrop(deleted_.front(), now));
}

absl::Status Compactor::Step(Store& store, collision::WallTime now) {
  if (IsPaused(now)) return absl::OkStatus();
  absl::Status status = TryStep(store, now);
  full_since_ = absl::IsResourceExhausted(status) ? std::optional(now) : std::nullopt;
  return status;
}

absl::Status Compactor::StepCurrent(Store& store) {
  absl::Status status = current_->Step(store);
  if (!current_->done()) return status;
  const bool is_too_large = current_->is_too_large();
  current_ = nullptr;
  if (is_too_large) ++not_folded_;
  const auto found = logs_.find(current_uid_);
  if (found == logs_.end()) return status;  // it was deleted meanwhile
  Log& log = found->second;
  log.max_records = limits_.max_records;
  log.max_bytes = limits_.max_bytes;
  if (!is_too_large) return status;
  log.max_records = std::max(log.max_records, 2 * log.begun_records);
  log.max_bytes = std::max(log.max_bytes, 2 * log.begun_bytes);
  log.old_records += log.begun_records;
  log.old_bytes += log.begun_bytes;
  return status;
}

absl::Status Compactor::TryStep(Store& store, collision::WallTime now) {
  if (current_ != nullptr) return StepCurrent(store);
  if (!deleted_.empty() && MayDrop(deleted_.front(), now)) {
    const Deleted& oldest = deleted_.front();
    absl::Status status = store.DropWorld(oldest.world_uid, oldest.sequence);
    if (status.ok()) deleted_.pop_front();
    return status;
  }
  if (due_.empty()) return absl::OkStatus();
  const std::string uid = std::move(due_.front());
  due_.pop_front();
  const auto found = logs_.find(uid);
  if (found == logs_.end()) return absl::OkStatus();  // it was deleted meanwhile
  Log& log = found->second;
  log.is_due = false;
  if (!IsLong(log)) return absl::OkStatus();  // it was found too large meanwhile
  current_ =
      std::make_unique<Compaction>(uid, log.old_sequence, retention_, limits_.max_snapshot_bytes);
  current_uid_ = uid;
  log.begun_records = std::exchange(log.old_records, 0);
  log.begun_bytes = std::exchange(log.old_bytes, 0);
  return absl::OkStatus();
}

}  // namespace cwm::server
