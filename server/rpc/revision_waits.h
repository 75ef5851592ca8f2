// Calls that wait for a revision which their world does not have yet.
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
  // As of a Task (fair_tasks.h).
  ClientId client = {};
  double cost_s = 0;
  bool may_answer_in_part = false;
};

// Thread safe. A wait holds no thread and no place in a queue until its revision is there; then it
// has a place of its own in the queue's lane of those who waited (a queue has as many as there may
// be waits), in the order in which they came: hundreds that wait for one revision neither push each
// other out nor those who come meanwhile.
class RevisionWaits {
 public:
  // `timer` is stopped before the end of this. More waits than `places` are refused.
  RevisionWaits(Timer& timer, FairQuotaOptions places) : timer_(timer), taken_(places) {}

  // Calls `then` once: on a thread of `queue` with the world's snapshot as soon as it has the
  // revision; else from some thread with the world's end, DeadlineExceeded, Cancelled, Draining or
  // Overloaded. Blocks nobody. A revision that is there already is work as any other.
  using Then = std::function<void(absl::StatusOr<SnapshotPtr>)>;
  void Await(RevisionWait wait, WorkQueue& queue, Then then);

  // Ends all waits, and those to come.
  void Drain() { draining_ = true; }

 private:
  struct Waiting {
    RevisionWait wait;
    WorkQueue& queue;
    Then then;
    std::shared_ptr<QuotaShare> place;  // until its work begins
  };

  void PollSoon();
  void Poll();
  // False when it has to go on waiting. `reached` is the revision of its world when this look at
  // all that wait began: what comes while it goes on is for the next one, else the last would be
  // first.
  bool TryEnd(Waiting& waiting, collision::Revision reached);
  void Admit(Waiting& waiting, SnapshotPtr snapshot);

  Timer& timer_;
  FairQuota taken_;  // by those who wait and by those who waited and have not begun
  std::atomic<bool> draining_ = false;
  std::mutex mutex_;
  std::list<Waiting> waiting_;  // in the order in which they came
  bool polling_ = false;        // a poll is due or under way
};

}  // namespace cwm::server
