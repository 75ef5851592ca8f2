#include "server/rpc/revision_waits.h"

#include <map>
#include <utility>

#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// chosen: well below the 10 ms within which a deadline has to end a wait.
constexpr auto kPollPeriod = std::chrono::milliseconds(5);

Task TaskOf(const RevisionWait& wait, std::function<void(const absl::Status&)> run) {
  return {.run = std::move(run),
          .client = wait.client,
          .cost_s = wait.cost_s,
          .deadline = wait.deadline,
          .allows_partial_answer = wait.allows_partial_answer};
}

}  // namespace

struct RevisionWaits::Waker {
  std::mutex mutex;
  RevisionWaits* waits = nullptr;  // nullptr: they are gone
  bool is_woken = false;           // EndReached is scheduled

  void Wake() {
    const std::lock_guard lock(mutex);
    if (waits == nullptr || std::exchange(is_woken, true)) return;
    waits->timer_.After({}, [this, waits = waits] {
      {
        const std::lock_guard woken(mutex);
        is_woken = false;
      }
      waits->EndReached();
    });
  }
};

RevisionWaits::RevisionWaits(Timer& timer, FairQuotaOptions quota)
    : timer_(timer), quota_(quota), waker_(std::make_shared<Waker>()) {
  waker_->waits = this;
}

RevisionWaits::~RevisionWaits() {
  const std::lock_guard lock(waker_->mutex);
  waker_->waits = nullptr;
}

void RevisionWaits::Await(RevisionWait wait, WorkQueue& queue, Then then) {
  if (SnapshotPtr latest = wait.world->Snapshot(); latest->revision() >= wait.revision) {
    return queue.Push(TaskOf(wait, [then = std::move(then), latest](const absl::Status& admitted) {
      if (!admitted.ok()) return then(admitted);
      then(latest);
    }));
  }
  auto quota_share = QuotaShare::TryTake(quota_, wait.client);
  if (!quota_share) return then(Overloaded("too many calls wait for a revision", "TOO_MANY_WAITS"));
  const std::shared_ptr<World> world = wait.world;
  const collision::Revision revision = wait.revision;
  auto subscription = world->WakeOnPublication([waker = waker_] { waker->Wake(); });
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back({std::move(wait), queue, std::move(then),
                        std::make_shared<QuotaShare>(*std::move(quota_share)),
                        std::move(subscription)});
    if (!std::exchange(polling_, true)) PollSoon();
  }
  if (world->Snapshot()->revision() >= revision) waker_->Wake();  // it came meanwhile
}

// The timer has one thread, so that rounds never overlap.
void RevisionWaits::PollSoon() {
  timer_.After(kPollPeriod, [this] {
    EndReached();
    const std::lock_guard lock(mutex_);
    polling_ = !waiting_.empty();
    if (polling_) PollSoon();
  });
}

void RevisionWaits::EndReached() {
  std::list<Waiting> polled;
  {
    const std::lock_guard lock(mutex_);
    polled.swap(waiting_);
  }
  // No lock is held, since ending a call may end others.
  std::map<const World*, collision::Revision> reached;
  for (const Waiting& waiting : polled) {
    const World& world = *waiting.wait.world;
    if (!reached.contains(&world)) reached.emplace(&world, world.Snapshot()->revision());
  }
  polled.remove_if(
      [&](Waiting& waiting) { return TryEnd(waiting, reached.at(waiting.wait.world.get())); });
  const std::lock_guard lock(mutex_);
  waiting_.splice(waiting_.begin(), polled);  // before those that arrived meanwhile
}

bool RevisionWaits::TryEnd(Waiting& waiting, collision::Revision reached) {
  const RevisionWait& wait = waiting.wait;
  const auto now = Clock::now();
  auto snapshot = wait.world->At(AtLeast{wait.revision}, now, wait.stop);
  const bool in_time = now < wait.deadline;
  if (snapshot.ok() && (reached >= wait.revision || !in_time || draining_)) {
    Admit(waiting, *std::move(snapshot));
    return true;
  }
  const bool not_yet = in_time && (snapshot.ok() || absl::IsDeadlineExceeded(snapshot.status()));
  if (not_yet && !draining_) return false;
  waiting.quota_share.reset();
  waiting.then(not_yet ? Draining() : snapshot.status());
  return true;
}

void RevisionWaits::Admit(Waiting& waiting, SnapshotPtr snapshot) {
  auto begin = [quota_share = std::move(waiting.quota_share), then = std::move(waiting.then),
                snapshot = std::move(snapshot)](const absl::Status& admitted) mutable {
    quota_share.reset();
    if (!admitted.ok()) return then(admitted);
    then(std::move(snapshot));
  };
  waiting.queue.Push(TaskOf(waiting.wait, std::move(begin)), WorkQueue::Lane::kAwaited);
}

}  // namespace cwm::server
