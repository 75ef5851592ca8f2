// Calls that wait for a revision that their world does not have yet.
#pragma once

#include <atomic>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <stop_token>

#include "absl/status/statusor.h"
#include "server/core/client_id.h"
#include "server/core/fair_quota.h"
#include "server/core/work_queue.h"
#include "server/core/world.h"
#include "server/rpc/timer.h"

namespace cwm::server {

struct RevisionWait {
  std::shared_ptr<World> world;
  collision::Revision revision;
  Clock::time_point deadline;
  std::stop_token stop;
  // The same as in Task (fair_tasks.h).
  ClientId client = {};
  double cost_s = 0;
  bool allows_partial_answer = false;
};

// Thread safe. A wait holds no thread and no place in a queue until its revision exists. Then it
// gets a place in the queue's lane kAwaited (which has as many places as there may be waits), in
// order of arrival: hundreds of calls that wait for one revision evict neither each other nor calls
// that arrive meanwhile.
class RevisionWaits {
 public:
  // `timer` must be stopped before the destructor runs. Waits above the `quota` are refused.
  RevisionWaits(Timer& timer, FairQuotaOptions quota);
  ~RevisionWaits();

  // Calls `then` once: on a thread of `queue` with the world's snapshot as soon as it has the
  // revision; otherwise on some thread with the world's end, DeadlineExceeded, Cancelled, Draining
  // or Overloaded. Never blocks. A wait for an existing revision is queued like any other work.
  using Then = std::function<void(absl::StatusOr<SnapshotPtr>)>;
  void Await(RevisionWait wait, WorkQueue& queue, Then then);

  // Ends all present and future waits.
  void Drain() { draining_ = true; }

 private:
  struct Waiting {
    RevisionWait wait;
    WorkQueue& queue;
    Then then;
    std::shared_ptr<QuotaShare> quota_share;        // until its work begins
    std::shared_ptr<const void> subscription = {};  // to the world
  };
  // Shared with the worlds that wake: one of them may do so when the waits are gone.
  struct Waker;

  // Publications end waits at once. Deadlines and cancelled calls are found by polling.
  void PollSoon();
  void EndReached();
  // False if it has to go on waiting. `reached` is the revision of its world when this round
  // began. A newer revision is left to the next round, since otherwise later waits would be
  // admitted before earlier ones.
  bool TryEnd(Waiting& waiting, collision::Revision reached);
  void Admit(Waiting& waiting, SnapshotPtr snapshot);

  Timer& timer_;
  FairQuota quota_;  // by waits, and by admitted calls that have not begun
  const std::shared_ptr<Waker> waker_;
  std::atomic<bool> draining_ = false;
  std::mutex mutex_;
  std::list<Waiting> waiting_;  // in order of arrival
  bool polling_ = false;        // a poll is scheduled or running
};

}  // namespace cwm::server
