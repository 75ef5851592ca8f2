#include "server/core/commit_pipeline.h"

#include <utility>

#include "server/core/failpoint.h"

namespace cwm::server {

CommitPipeline::CommitPipeline(Journal* journal, std::mutex& turn,
                               std::function<SnapshotPtr()> latest, Owner owner)
    : journal_(journal), turn_(turn), latest_(std::move(latest)), owner_(std::move(owner)) {}

SnapshotPtr CommitPipeline::Tip() const {
  if (journal_ != nullptr) {
    const std::lock_guard lock(mutex_);
    if (tip_ != nullptr) return tip_;
  }
  return latest_();
}

std::size_t CommitPipeline::size() const {
  const std::lock_guard lock(mutex_);
  return queue_.size();
}

// The writer is answered first: a thread that is woken takes the core of the one that wakes it.
void CommitPipeline::AfterTurn::Finish() const {
  if (answered != nullptr && answered->done) answered->done(std::move(answered->outcome));
  post_commit.Finish();
}

CommitPipeline::AfterTurn CommitPipeline::Push(PendingWritePtr write,
                                               std::shared_ptr<const void> keep_alive) noexcept {
  if (journal_ == nullptr) {
    WorldFeed::PostCommit post_commit;
    if (write->has_entry) post_commit = owner_.publish(*write);
    return {.post_commit = std::move(post_commit), .answered = std::move(write)};
  }
  {
    const std::lock_guard lock(mutex_);
    if (!write->has_entry && queue_.empty()) return {.answered = std::move(write)};
    queue_.push_back(write);
    if (write->next != nullptr) tip_ = write->next;
  }
  if (!write->has_entry) return {};
  journal_->Append(write->entry,
                   [this, write, alive = std::move(keep_alive)](const absl::Status& status) {
                     status.ok() ? OnJournaled(write) : OnRefused(write, status);
                   });
  return {};
}

// The journal calls this for one entry after the other, so `write` is the first of the queue.
void CommitPipeline::OnJournaled(const PendingWritePtr& write) {
  const WorldFeed::PostCommit post_commit = owner_.publish(*write);
  std::vector<PendingWritePtr> answered;
  {
    const std::lock_guard lock(mutex_);
    do {
      answered.push_back(std::move(queue_.front()));
      queue_.pop_front();
    } while (!queue_.empty() && !queue_.front()->has_entry);
    // derived: readers of the tip then read the published snapshot, which the last entry made.
    if (queue_.empty()) tip_ = nullptr;
  }
  FailPoint("after-publish");
  for (const PendingWritePtr& each : answered) {
    if (each->done) each->done(std::move(each->outcome));
  }
  post_commit.Finish();
}

// Nothing of the entry was written, and every later write of this world builds on it: all of them
// are rolled back and refused.
void CommitPipeline::OnRefused(const PendingWritePtr& write, const absl::Status& status) {
  std::deque<PendingWritePtr> lost;
  {
    const std::lock_guard turn(turn_);
    if (write->is_void) return;  // it was rolled back with an earlier one
    {
      const std::lock_guard lock(mutex_);
      lost.swap(queue_);
      tip_ = nullptr;
    }
    for (const PendingWritePtr& each : lost) each->is_void = true;
    owner_.roll_back(lost);
  }
  for (const PendingWritePtr& each : lost) {
    if (each->done) each->done(status);
  }
}

}  // namespace cwm::server
