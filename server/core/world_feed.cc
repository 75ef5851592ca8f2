#include "server/core/world_feed.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

using collision::Revision;
using collision::WorldSnapshot;

absl::Status Compacted(Revision wanted, Revision oldest, Revision latest) {
  return MakeError(
      absl::StatusCode::kOutOfRange,
      absl::StrCat("revision: ", wanted.value, " is no longer kept, the oldest is ", oldest.value),
      {.reason = "REVISION_COMPACTED",
       .metadata = {{"oldest_revision", std::to_string(oldest.value)},
                    {"latest_revision", std::to_string(latest.value)}}});
}

absl::Status ExactCompacted(Revision wanted, const History& history) {
  const Revision nearest = history.NearestExact(wanted);
  const Revision oldest = history.oldest_exact(), latest = history.latest();
  return MakeError(
      absl::StatusCode::kOutOfRange,
      absl::StrCat("revision: ", wanted.value, " is no longer kept, the nearest kept one is ",
                   nearest.value, ", the oldest ", oldest.value, ", the latest ", latest.value),
      {.reason = "REVISION_COMPACTED",
       .metadata = {{"nearest_revision", std::to_string(nearest.value)},
                    {"oldest_revision", std::to_string(oldest.value)},
                    {"latest_revision", std::to_string(latest.value)}}});
}

absl::Status InFuture(Revision wanted, Revision latest) {
  return MakeError(
      absl::StatusCode::kOutOfRange,
      absl::StrCat("revision: ", wanted.value, " is not made yet, the latest is ", latest.value),
      {.reason = "REVISION_IN_FUTURE",
       .metadata = {{"latest_revision", std::to_string(latest.value)}}});
}

}  // namespace

absl::Status WorldDeleted() {
  return MakeError(absl::StatusCode::kNotFound, "world: it was deleted",
                   {.reason = "WORLD_DELETED"});
}

void WorldFeed::PostCommit::Finish() const {
  for (const auto& wake : wakes) (*wake)();
}

WorldFeed::WorldFeed(Retention retention, std::function<Clock::time_point()> now,
                     MemoryCharge charge, SnapshotPtr first)
    : now_(std::move(now)),
      latest_(std::move(first)),
      history_(retention, latest_, std::move(charge)) {}

SnapshotPtr WorldFeed::Latest() const {
  std::lock_guard lock(latest_mutex_);
  return latest_;
}

EndReason WorldFeed::end_reason() const {
  std::lock_guard lock(mutex_);
  return end_reason_;
}

absl::StatusOr<SnapshotPtr> WorldFeed::At(const RevisionRule& rule, Clock::time_point deadline,
                                          std::stop_token stop) const {
  if (const auto* exactly = std::get_if<Exactly>(&rule)) return Exact(exactly->revision);
  if (const auto* at_least = std::get_if<AtLeast>(&rule)) {
    return WaitFor(at_least->revision, deadline, std::move(stop));
  }
  return Latest();
}

absl::StatusOr<SnapshotPtr> WorldFeed::Exact(Revision revision) const {
  const Clock::time_point now = now_();
  std::lock_guard lock(mutex_);
  if (revision > history_.latest()) return InFuture(revision, history_.latest());
  SnapshotPtr snapshot = history_.Use(revision, now);
  if (snapshot == nullptr) return ExactCompacted(revision, history_);
  return snapshot;
}

absl::StatusOr<SnapshotPtr> WorldFeed::WaitFor(Revision revision, Clock::time_point deadline,
                                               std::stop_token stop) const {
  if (SnapshotPtr latest = Latest(); latest->revision() >= revision) return latest;
  std::unique_lock lock(mutex_);
  published_or_ended_.wait_until(lock, stop, deadline, [&] {
    return history_.latest() >= revision || end_reason_ == EndReason::kDeleted;
  });
  if (history_.latest() >= revision) return history_.SnapshotAt(history_.latest());
  if (end_reason_ == EndReason::kDeleted) return WorldDeleted();
  if (stop.stop_requested()) return absl::CancelledError("the caller went away");
  return MakeError(absl::StatusCode::kDeadlineExceeded,
                   absl::StrCat("revision: ", revision.value, " was not reached, the latest is ",
                                history_.latest().value),
                   {.reason = "REVISION_IN_FUTURE",
                    .metadata = {{"latest_revision", std::to_string(history_.latest().value)}}});
}

Revision WorldFeed::oldest_exact() const {
  std::lock_guard lock(mutex_);
  return history_.oldest_exact();
}

Revision WorldFeed::oldest_watch() {
  History::Dropped dropped;  // freed after the lock
  const Clock::time_point now = now_();
  std::lock_guard lock(mutex_);
  dropped = history_.Expire(now);
  return history_.oldest_watch();
}

void WorldFeed::RestoreEvents(std::span<const EventPtr> events, Revision from) {
  const std::lock_guard lock(mutex_);
  history_.RestoreEvents(events, from);
}

WorldFeed::PostCommit WorldFeed::Publish(SnapshotPtr next, EventPtr event) {
  PostCommit post_commit;
  {
    std::lock_guard lock(mutex_);
    // History first, so that whoever sees the new snapshot finds its revision and its event.
    post_commit.dropped = history_.Append(next, std::move(event));
    post_commit.wakes = subscriptions_;
    std::lock_guard latest_lock(latest_mutex_);
    latest_.swap(next);  // the old snapshot is freed after the locks
  }
  published_or_ended_.notify_all();
  return post_commit;
}

WorldFeed::PostCommit WorldFeed::End(EndReason end_reason) {
  PostCommit post_commit;
  {
    std::lock_guard lock(mutex_);
    if (end_reason_ != EndReason::kDeleted) end_reason_ = end_reason;
    post_commit.wakes = subscriptions_;
  }
  published_or_ended_.notify_all();
  return post_commit;
}

void WorldFeed::DropHistory() {
  History::Dropped dropped;  // freed after the lock
  const std::lock_guard lock(mutex_);
  dropped = history_.DropHistory();
}

absl::Status WorldFeed::CheckResume(Revision from) const {
  if (from > history_.latest()) return InFuture(from, history_.latest());
  if (from < history_.oldest_watch() || !history_.WasMade(from)) {
    return Compacted(from, history_.oldest_watch(), history_.latest());
  }
  return absl::OkStatus();
}

absl::StatusOr<WorldFeed::Start> WorldFeed::Subscribe(const WatchOptions& options, Wake wake) {
  Start start;
  start.subscription = std::make_shared<const Wake>(std::move(wake));
  const Clock::time_point now = now_();
  History::Dropped dropped;  // freed after the lock
  std::lock_guard lock(mutex_);
  if (end_reason_ == EndReason::kDeleted) return WorldDeleted();
  if (end_reason_ == EndReason::kDraining) return ServerDraining();
  dropped = history_.Expire(now);
  start.latest = history_.SnapshotAt(history_.latest());
  if (options.from_revision.has_value()) {
    const absl::Status resumable = CheckResume(*options.from_revision);
    if (!resumable.ok()) return resumable;
    start.from = history_.SnapshotAt(*options.from_revision);
    if (start.from == nullptr) start.missed = history_.EventsAfter(*options.from_revision);
  }
  subscriptions_.push_back(start.subscription);
  return start;
}

std::shared_ptr<const WorldFeed::Wake> WorldFeed::Subscribe(Wake wake) {
  auto subscription = std::make_shared<const Wake>(std::move(wake));
  const std::lock_guard lock(mutex_);
  subscriptions_.push_back(subscription);
  return subscription;
}

void WorldFeed::Unsubscribe(const std::shared_ptr<const Wake>& subscription) {
  std::lock_guard lock(mutex_);
  std::erase(subscriptions_, subscription);
}

WorldFeed::ReadResult WorldFeed::ReadAfter(Revision position) const {
  std::lock_guard lock(mutex_);
  ReadResult result{.event = history_.EventFrom(position),
                    .compacted = false,
                    .oldest_watch = history_.oldest_watch(),
                    .end_reason = end_reason_};
  result.compacted = result.event == nullptr && position < history_.latest();
  return result;
}

}  // namespace cwm::server
