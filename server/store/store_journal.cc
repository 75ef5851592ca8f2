#include "server/store/store_journal.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <set>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/store/encode_entry.h"
#include "server/store/keep_blobs.h"
#include "server/store/world_fold.h"

namespace cwm::server {
namespace {

// chosen: a transaction of so much takes some milliseconds.
constexpr std::size_t kMaxBatchRecords = 1'024;
constexpr std::size_t kMaxBatchBytes = std::size_t{4} << 20;
// chosen: after so long without an entry the journal does what can wait.
constexpr std::chrono::milliseconds kIdleTime = std::chrono::milliseconds(20);
// chosen: how often it looks for blobs that nothing uses, while nobody writes.
constexpr std::chrono::milliseconds kRestTime = std::chrono::minutes(1);
// chosen: under load the log grows by some megabytes meanwhile.
constexpr int kBatchesUntilMaintenance = 256;
// derived: fewer records than the numbers that recovery skips, with the batch under way.
constexpr std::int64_t kMaxUnflushed = kRevisionsLostAtMost / 2;
static_assert(kMaxUnflushed + static_cast<std::int64_t>(kMaxBatchRecords) < kRevisionsLostAtMost);
// chosen: how often a lost reply is asked for again.
constexpr int kAppendTries = 5;

absl::Status Closing() { return ServerDraining(); }

// A name is never given twice, so a power cut must not take it.
bool MustFlush(const JournalEntry& entry) {
  if (entry.durability == Durability::kDurable || entry.created_name.has_value()) return true;
  const auto* write = std::get_if<WorldWrite>(&entry.what);
  return write != nullptr && !write->last_numbers.empty();
}

}  // namespace

StoreJournal::StoreJournal(std::unique_ptr<Store> store, Compactor compactor, OnFailure on_failure,
                           Warn warn)
    : store_(std::move(store)),
      on_failure_(std::move(on_failure)),
      warn_(std::move(warn)),
      compactor_(std::move(compactor)),
      sequence_(store_->last_sequence()),
      thread_([this] { Run(); }) {}

StoreJournal::~StoreJournal() { Close().IgnoreError(); }

void StoreJournal::Append(const JournalEntry& entry, Done done) {
  Item item{.record = {.epoch = store_->epoch(),
                       .world_uid = entry.world_uid,
                       .revision = entry.revision.value},
            .logged = Compactor::LoggedOf(entry),
            .flush = MustFlush(entry),
            .may_use_reserve = entry.may_use_reserve,
            .fault = absl::OkStatus(),
            .done = std::move(done)};
  try {
    absl::StatusOr<EncodedEntry> encoded = EncodeEntry(entry, *store_);
    if (encoded.ok()) {
      item.record.payload = std::move(encoded->payload);
      item.record.blobs = std::move(encoded->blobs);
    } else {
      item.fault = encoded.status();
    }
  } catch (const std::bad_alloc&) {
    item.fault = Overloaded("the server has not enough memory for this write", "OUT_OF_MEMORY", 1);
  }
  {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(item));
  }
  wake_.notify_one();
}

absl::Status StoreJournal::KeepGeometry(std::span<const PreparedModelPtr> models,
                                        Durability durability) {
  return cwm::server::KeepGeometry(*store_, models, durability);
}

absl::StatusOr<std::string> StoreJournal::KeepRobotFiles(const RobotFiles& files) {
  return cwm::server::KeepRobotFiles(*store_, files);
}

StoreInfo StoreJournal::info() const {
  const StoreStats stats = store_->stats();
  const std::lock_guard lock(mutex_);
  return {.sequence = sequence_,
          .epoch = store_->epoch(),
          .record_count = stats.record_count,
          .bytes = stats.bytes,
          .blob_count = stats.blob_count,
          .refuses_writes = refuses_writes_};
}

void StoreJournal::StartBackup(BackupDone done) {
  {
    const std::lock_guard lock(mutex_);
    if (!is_closing_) {
      backups_.push_back(std::move(done));
      done = nullptr;
    }
  }
  if (done) return done(Closing());
  wake_.notify_one();
}

absl::Status StoreJournal::Close() {
  {
    const std::lock_guard lock(mutex_);
    is_closing_ = true;
  }
  wake_.notify_one();
  if (thread_.joinable()) thread_.join();
  return closed_;
}

void StoreJournal::Run() {
  std::unique_lock lock(mutex_);
  while (!has_failed_) {
    const auto has_work = [this] { return !queue_.empty() || is_closing_ || !backups_.empty(); };
    const bool has_news =
        batches_since_maintenance_ > 0 || compactor_.IsDue(std::chrono::system_clock::now());
    const bool is_idle = !wake_.wait_for(lock, has_news ? kIdleTime : kRestTime, has_work);
    const bool is_last = is_closing_ && queue_.empty();
    lock.unlock();
    if (is_last) break;
    if (Items batch = TakeBatch(); !batch.empty()) {
      Commit(std::move(batch));
      ++batches_since_maintenance_;
    }
    StepBackup();
    StepCompaction();
    if (is_idle || batches_since_maintenance_ >= kBatchesUntilMaintenance) WorkInBackground();
    lock.lock();
  }
  if (lock.owns_lock()) lock.unlock();
  std::deque<BackupDone> backups;
  {
    const std::lock_guard guard(mutex_);
    backups.swap(backups_);
  }
  backup_run_ = nullptr;
  for (const BackupDone& done : backups) done(Closing());
  if (!has_failed_) closed_ = store_->Close();
}

StoreJournal::Items StoreJournal::TakeBatch() {
  Items batch;
  std::size_t bytes = 0;
  const std::lock_guard lock(mutex_);
  while (!queue_.empty() && batch.size() < kMaxBatchRecords && bytes < kMaxBatchBytes) {
    if (!queue_.front().fault.ok() && !batch.empty()) break;  // it is refused by itself
    bytes += queue_.front().record.payload.size();
    batch.push_back(std::move(queue_.front()));
    queue_.pop_front();
    if (!batch.back().fault.ok()) break;
  }
  return batch;
}

// The entries that may be written without room, and the others. An entry may be written only if all
// earlier ones of its world are.
std::pair<StoreJournal::Items, StoreJournal::Items> StoreJournal::SplitForReserve(Items batch) {
  std::pair<Items, Items> parts;
  std::set<std::string> refused_worlds;
  for (Item& item : batch) {
    const std::string& world = item.record.world_uid;
    const bool may_write = item.may_use_reserve && !refused_worlds.contains(world);
    if (!may_write) refused_worlds.insert(world);
    (may_write ? parts.first : parts.second).push_back(std::move(item));
  }
  return parts;
}

void StoreJournal::Commit(Items batch) {
  if (!batch.front().fault.ok()) {
    const absl::Status fault = batch.front().fault;
    return Refuse(std::move(batch), fault);
  }
  const absl::Status room = store_->CheckRoom();
  if (room.ok()) return Write(std::move(batch));
  if (!absl::IsResourceExhausted(room)) return Fail(room);
  auto [reserved, refused] = SplitForReserve(std::move(batch));
  if (!reserved.empty()) Write(std::move(reserved));
  if (!has_failed_ && !refused.empty()) Refuse(std::move(refused), room);
}

void StoreJournal::Write(Items batch) {
  std::vector<StoredRecord> records;
  records.reserve(batch.size());
  bool flush = unflushed_ + static_cast<std::int64_t>(batch.size()) > kMaxUnflushed;
  for (Item& item : batch) {
    item.logged.bytes = static_cast<std::int64_t>(item.record.payload.size());
    item.record.sequence = store_->last_sequence() + 1 + static_cast<std::int64_t>(records.size());
    flush = flush || item.flush;
    records.push_back(std::move(item.record));
  }
  const auto result = AppendToStore(records, flush ? Durability::kDurable : Durability::kObserved);
  if (absl::IsResourceExhausted(result.status())) {
    for (std::size_t i = 0; i < batch.size(); ++i) batch[i].record = std::move(records[i]);
    return Refuse(std::move(batch), result.status());
  }
  if (!result.ok()) return Fail(result.status());
  if (*result == AppendResult::kSuperseded) {
    return Fail(MakeError(absl::StatusCode::kFailedPrecondition,
                          "another server writes to the same store", {.reason = "STORE_FAILED"}));
  }
  unflushed_ = flush ? 0 : unflushed_ + static_cast<std::int64_t>(batch.size());
  sequence_ = store_->last_sequence();
  {
    const std::lock_guard lock(mutex_);
    refuses_writes_.clear();
  }
  for (std::size_t i = 0; i < batch.size(); ++i) {
    batch[i].logged.sequence = records[i].sequence;
    compactor_.Add(batch[i].logged);
    batch[i].done(absl::OkStatus());
  }
}

absl::StatusOr<AppendResult> StoreJournal::AppendToStore(const std::vector<StoredRecord>& records,
                                                         Durability durability) {
  for (int i = 0; i < kAppendTries; ++i) {
    const absl::StatusOr<AppendResult> result = store_->Append(records, durability);
    if (!result.ok() || *result != AppendResult::kUnknown) return result;
    const absl::StatusOr<bool> is_there = HasRecord(records.front());
    if (!is_there.ok()) return is_there.status();
    if (*is_there) return AppendResult::kDurable;  // all or none of them
  }
  return MakeError(absl::StatusCode::kUnavailable, "the store does not answer",
                   {.reason = "STORE_FAILED"});
}

absl::StatusOr<bool> StoreJournal::HasRecord(const StoredRecord& record) {
  const auto found = store_->Follow("", record.sequence - 1, 1);
  if (!found.ok()) return found.status();
  return !found->empty() && found->front().sequence == record.sequence &&
         found->front().epoch == record.epoch && found->front().payload == record.payload;
}

void StoreJournal::Refuse(Items items, const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    refuses_writes_ = std::string(status.message());
  }
  while (!items.empty()) {
    const Item item = std::move(items.front());
    items.pop_front();
    item.done(status);
    // Entries that came meanwhile build on this one, or on the state to which the world went back;
    // they are refused alike, which the world cannot tell apart.
    const std::lock_guard lock(mutex_);
    Items others;
    for (Item& waiting : queue_) {
      const bool is_same = waiting.record.world_uid == item.record.world_uid;
      (is_same ? items : others).push_back(std::move(waiting));
    }
    queue_ = std::move(others);
  }
}

void StoreJournal::StepBackup() {
  {
    const std::lock_guard lock(mutex_);
    if (backups_.empty()) return;
  }
  const auto step = [this]() -> absl::StatusOr<std::unique_ptr<Backup>> {
    if (backup_run_ == nullptr) {
      auto run = store_->StartBackup();
      if (!run.ok()) return run.status();
      backup_run_ = *std::move(run);
    }
    return backup_run_->Step();
  };
  absl::StatusOr<std::unique_ptr<Backup>> made = step();
  if (made.ok() && *made == nullptr) return;
  backup_run_ = nullptr;
  BackupDone done;
  {
    const std::lock_guard lock(mutex_);
    done = std::move(backups_.front());
    backups_.pop_front();
  }
  if (!made.ok()) return done(made.status());
  done(std::shared_ptr<const Backup>(*std::move(made)));
}

// One step after each batch, so that a log that grows fast is folded fast.
void StoreJournal::StepCompaction() {
  const auto now = std::chrono::system_clock::now();
  if (has_failed_ || !compactor_.IsDue(now)) return;
  const absl::Status status = compactor_.Step(*store_, now);
  if (!status.ok() && !absl::IsResourceExhausted(status)) return Fail(status);
  if (compactor_.not_folded() == not_folded_) return;
  not_folded_ = compactor_.not_folded();
  if (warn_) warn_("a world is too large to be folded into one snapshot, so its log grows on");
}

void StoreJournal::WorkInBackground() {
  batches_since_maintenance_ = 0;
  const absl::Status maintained = store_->Maintain();
  if (!maintained.ok() && !absl::IsResourceExhausted(maintained)) Fail(maintained);
}

void StoreJournal::Fail(const absl::Status& status) {
  has_failed_ = true;
  closed_ = status;
  on_failure_(status);
}

}  // namespace cwm::server
