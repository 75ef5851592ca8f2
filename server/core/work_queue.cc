#include "server/core/work_queue.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "server/core/error.h"

namespace cwm::server {
namespace {

// Linux shows at most 15 characters of a thread's name.
constexpr std::size_t kThreadNameLength = 15;
// chosen: the least delay before a retry that a refusal suggests; the queue has advanced by then.
constexpr double kMinRetry_s = 0.1;
// Estimates of cost are corrected by the true durations of tasks, in an exponential average over
// about ten of them.
constexpr double kNewestWeight = 0.1;
constexpr double kFirstTasks_s = 0.1;
// A task is refused for its deadline only if less than this share of its estimated time is left:
// estimates may be too high by a factor of four.
constexpr double kCostDoubt = 0.25;

// Marks the server's own work, which may wait as long as it takes.
constexpr auto kNeverLate = Clock::time_point::max();

void SetThreadNameAndNice(const WorkQueueOptions& options) {
  pthread_setname_np(pthread_self(), options.name.substr(0, kThreadNameLength).c_str());
  if (options.nice == 0) return;
  // On Linux the nice value belongs to the thread. If it is refused (raising a priority needs a
  // permission), the default remains, which slows others but is never wrong.
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), options.nice);
}

double Seconds(Clock::duration duration) { return std::chrono::duration<double>(duration).count(); }

}  // namespace

struct WorkQueue::State {
  WorkQueueOptions options;
  mutable std::mutex mutex;
  std::condition_variable work_or_drain;
  std::condition_variable caller_left;
  std::array<FairTasks, 2> lanes;  // by Lane
  bool awaited_is_next = false;    // if both lanes have tasks
  bool draining = false;
  bool lends_caller = false;  // a caller's thread runs a task of the queue
  int under_way = 0;
  double under_way_cost_s = 0;
  // True and estimated seconds of past tasks; newer tasks weigh more.
  double took_s = kFirstTasks_s;
  double spent_s = kFirstTasks_s;
  Clock::time_point last_end = Clock::time_point::min();  // min: no task yet
  std::atomic<std::int64_t> failed{0};
  std::mutex join_mutex;  // several threads may drain at once
  std::vector<std::thread> threads;

  FairTasks& lane(Lane lane) { return lanes[lane == Lane::kNew ? 0 : 1]; }
  const FairTasks& lane(Lane lane) const { return lanes[lane == Lane::kNew ? 0 : 1]; }
  std::size_t CapacityOf(Lane lane) const {
    return lane == Lane::kNew ? options.capacity : options.awaited_capacity;
  }
  bool empty() const { return lanes[0].empty() && lanes[1].empty(); }

  Lane NextLane() {
    if (lane(Lane::kNew).empty()) return Lane::kAwaited;
    if (lane(Lane::kAwaited).empty()) return Lane::kNew;
    return std::exchange(awaited_is_next, !awaited_is_next) ? Lane::kAwaited : Lane::kNew;
  }

  // The estimated seconds until a task of the client would start. The lanes take turns, so the
  // other lane delays it by at most as much as its own.
  double WaitOf(const ClientId& client, Lane its_lane) const {
    if (under_way < options.threads && empty()) return 0;
    const FairTasks& own = lane(its_lane);
    const FairTasks& other = lane(its_lane == Lane::kNew ? Lane::kAwaited : Lane::kNew);
    const double before_s = own.CostBefore(client);
    const double cost_s =
        under_way_cost_s / 2 + before_s + std::min(before_s, other.CostBefore(client));
    return cost_s * took_s / spent_s / options.threads;
  }

  absl::Status Refusal(const ClientId& client, Lane its_lane) const {
    const double wait_s = WaitOf(client, its_lane);
    return Overloaded(absl::StrCat("the queue \"", options.name,
                                   "\" is full: ", lanes[0].size() + lanes[1].size(),
                                   " calls wait, for some ", absl::StrFormat("%.1f s", wait_s)),
                      "QUEUE_FULL", std::max(kMinRetry_s, wait_s));
  }

  // OK if the task's turn came in time, else the refusal.
  absl::Status Admit(const Task& task) const {
    if (task.pushed == kNeverLate) return absl::OkStatus();
    const auto now = Clock::now();
    if (now - task.pushed > options.max_wait) {
      return Overloaded(absl::StrCat("the queue \"", options.name, "\" is too slow: waited for ",
                                     absl::StrFormat("%.1f s", Seconds(now - task.pushed))),
                        "QUEUE_FULL", std::max(kMinRetry_s, Seconds(now - task.pushed)));
    }
    if (task.deadline == Clock::time_point::max()) return absl::OkStatus();
    const double needed_s =
        task.allows_partial_answer ? 0 : kCostDoubt * task.cost_s * took_s / spent_s;
    if (Seconds(task.deadline - now) >= needed_s) return absl::OkStatus();
    return MakeError(absl::StatusCode::kDeadlineExceeded,
                     "the deadline came too soon for the work to begin",
                     {.reason = "DEADLINE_TOO_SHORT",
                      .fields = {},
                      .metadata = {},
                      .retry_after_s = std::max(kMinRetry_s, needed_s)});
  }

  struct Turn {
    Task task;
    absl::Status admitted;
    Lane lane = Lane::kNew;
  };
  // Waits for the next task. Its function is empty if the queue is draining and has no tasks.
  Turn Take() {
    std::unique_lock lock(mutex);
    work_or_drain.wait(lock, [this] { return draining || !empty(); });
    if (empty()) return {};
    const Lane next = NextLane();
    Turn turn{.task = lane(next).Pop(), .admitted = absl::OkStatus(), .lane = next};
    turn.admitted = Admit(turn.task);
    ++under_way;
    under_way_cost_s += turn.task.cost_s;
    return turn;
  }

  // Ends a task that the caller's thread ran without waiting (TryRunInline).
  void EndedHere() {
    std::lock_guard lock(mutex);
    NoteEnd();
  }

  void Ended(const Turn& turn, Clock::duration took) {
    const double cost_s = turn.task.cost_s;
    std::lock_guard lock(mutex);
    under_way_cost_s -= cost_s;
    // A refused task took next to no time.
    const double spent = turn.admitted.ok() ? Seconds(took) * spent_s / took_s : 0;
    lane(turn.lane).Correct(turn.task.client, spent - cost_s);
    NoteEnd();
    if (!turn.admitted.ok() || cost_s <= 0) return;
    took_s = (1 - kNewestWeight) * took_s + Seconds(took);
    spent_s = (1 - kNewestWeight) * spent_s + cost_s;
  }

  void NoteEnd() {
    --under_way;
    last_end = Clock::now();
    if (under_way > 0 || !empty()) return;
    for (FairTasks& tasks : lanes) tasks.ForgetDebts();
  }

  template <class Run>
  void RunGuarded(const Run& run) {
    try {
      run();
    } catch (...) {  // a task that throws must not end the server
      failed.fetch_add(1, std::memory_order_relaxed);
    }
  }

  void Serve() {
    SetThreadNameAndNice(options);
    for (;;) {
      const Turn turn = Take();
      if (!turn.task.run) return;
      const auto begin = Clock::now();
      RunGuarded([&turn] { turn.task.run(turn.admitted); });
      Ended(turn, Clock::now() - begin);
    }
  }

  bool TakeCaller() {
    std::lock_guard lock(mutex);
    if (draining || lends_caller || !empty() || under_way >= options.threads) return false;
    ++under_way;
    lends_caller = true;
    return true;
  }

  void LeaveCaller() {
    std::lock_guard lock(mutex);  // held during notify, since the drainer may destroy the queue
                                  // afterwards
    lends_caller = false;
    caller_left.notify_all();
  }
};

WorkQueue::WorkQueue(WorkQueueOptions options) : state_(std::make_unique<State>()) {
  state_->options = std::move(options);
  state_->threads.reserve(static_cast<std::size_t>(state_->options.threads));
  for (int i = 0; i < state_->options.threads; ++i) {
    state_->threads.emplace_back([state = state_.get()] { state->Serve(); });
  }
}

WorkQueue::~WorkQueue() { Drain(); }

void WorkQueue::Push(Task task, Lane lane) {
  task.cost_s = std::max(task.cost_s, FairTasks::kMinCost_s);
  absl::Status refusal;
  {
    std::lock_guard lock(state_->mutex);
    FairTasks& tasks = state_->lane(lane);
    if (state_->draining) {
      refusal = ServerDraining();
    } else if (state_->WaitOf(task.client, lane) > state_->options.max_wait.count()) {
      refusal = state_->Refusal(task.client, lane);
    } else if (tasks.size() >= state_->CapacityOf(lane)) {
      std::optional<Task> longest = tasks.TakeFromLongest(task.client);
      refusal = state_->Refusal(longest ? longest->client : task.client, lane);
      if (longest) {
        task.pushed = Clock::now();
        tasks.Push(std::exchange(task, *std::move(longest)));
      }
    } else {
      task.pushed = Clock::now();
      tasks.Push(std::exchange(task, {}));
    }
  }
  state_->work_or_drain.notify_one();
  if (!refusal.ok()) state_->RunGuarded([&] { task.run(refusal); });
}

bool WorkQueue::TryPush(std::function<void()> task, Lane lane) {
  {
    std::lock_guard lock(state_->mutex);
    FairTasks& tasks = state_->lane(lane);
    if (state_->draining || tasks.size() >= state_->CapacityOf(lane)) return false;
    Task own;
    own.run = [run = std::move(task)](const absl::Status&) { run(); };
    own.pushed = kNeverLate;
    tasks.Push(std::move(own));
  }
  state_->work_or_drain.notify_one();
  return true;
}

bool WorkQueue::TryRunInline(const std::function<void()>& task) {
  if (!state_->TakeCaller()) return false;
  state_->RunGuarded(task);
  state_->EndedHere();
  state_->LeaveCaller();
  return true;
}

void WorkQueue::Drain() {
  {
    std::lock_guard lock(state_->mutex);
    state_->draining = true;
  }
  state_->work_or_drain.notify_all();
  {
    std::unique_lock lock(state_->mutex);
    state_->caller_left.wait(lock, [this] { return !state_->lends_caller; });
  }
  std::lock_guard lock(state_->join_mutex);
  for (std::thread& thread : state_->threads) {
    if (thread.joinable()) thread.join();
  }
}

std::size_t WorkQueue::waiting() const {
  std::lock_guard lock(state_->mutex);
  return state_->lanes[0].size() + state_->lanes[1].size();
}

Clock::duration WorkQueue::IdleFor() const {
  std::lock_guard lock(state_->mutex);
  if (state_->under_way > 0 || !state_->empty()) return Clock::duration::zero();
  if (state_->last_end == Clock::time_point::min()) return Clock::duration::max();
  return Clock::now() - state_->last_end;
}

std::int64_t WorkQueue::failed() const { return state_->failed.load(std::memory_order_relaxed); }

}  // namespace cwm::server
