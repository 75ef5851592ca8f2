#include "server/core/work_queue.h"

#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace cwm::server {
namespace {

// Linux shows at most 15 characters of a thread's name.
constexpr std::size_t kThreadNameLength = 15;

void NameAndRankThisThread(const WorkQueueOptions& options) {
  pthread_setname_np(pthread_self(), options.name.substr(0, kThreadNameLength).c_str());
  if (options.nice == 0) return;
  // On Linux the nice value belongs to the thread. A refusal (raising priority without the right
  // to) leaves the default, which is slower for others but never wrong.
  setpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid)), options.nice);
}

}  // namespace

struct WorkQueue::State {
  WorkQueueOptions options;
  mutable std::mutex mutex;
  std::condition_variable work_or_drain;
  std::condition_variable caller_left;
  using Tasks = std::deque<std::function<void()>>;
  Tasks tasks;
  Tasks awaited;
  bool awaited_is_next = false;  // where both have some
  bool draining = false;
  bool lends_caller = false;  // one runs a task of the queue
  int under_way = 0;
  Clock::time_point last_end = Clock::time_point::min();  // min: no task yet
  std::atomic<std::int64_t> failed{0};
  std::mutex join_mutex;  // several may drain at once
  std::vector<std::thread> threads;

  bool empty() const { return tasks.empty() && awaited.empty(); }

  Tasks& NextLane() {
    if (tasks.empty()) return awaited;
    if (awaited.empty()) return tasks;
    return std::exchange(awaited_is_next, !awaited_is_next) ? awaited : tasks;
  }

  // The next task, or nothing when draining and empty.
  std::function<void()> Take() {
    std::unique_lock lock(mutex);
    work_or_drain.wait(lock, [this] { return draining || !empty(); });
    if (empty()) return nullptr;
    Tasks& lane = NextLane();
    std::function<void()> task = std::move(lane.front());
    lane.pop_front();
    ++under_way;
    return task;
  }

  void Ended() {
    std::lock_guard lock(mutex);
    --under_way;
    last_end = Clock::now();
  }

  void Run(const std::function<void()>& task) {
    try {
      task();
    } catch (...) {  // one bad task must not end the server
      failed.fetch_add(1, std::memory_order_relaxed);
    }
    Ended();
  }

  void Serve() {
    NameAndRankThisThread(options);
    while (const std::function<void()> task = Take()) Run(task);
  }

  bool TakeCaller() {
    std::lock_guard lock(mutex);
    if (draining || lends_caller || !empty() || under_way >= options.threads) return false;
    ++under_way;
    lends_caller = true;
    return true;
  }

  void LeaveCaller() {
    std::lock_guard lock(mutex);  // until it is told: who drains may destroy the queue then
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

bool WorkQueue::TryPush(std::function<void()> task, Lane lane) {
  const bool is_new = lane == Lane::kNew;
  const WorkQueueOptions& options = state_->options;
  const std::size_t capacity = is_new ? options.capacity : options.awaited_capacity;
  {
    std::lock_guard lock(state_->mutex);
    State::Tasks& tasks = is_new ? state_->tasks : state_->awaited;
    if (state_->draining || tasks.size() >= capacity) return false;
    tasks.push_back(std::move(task));
  }
  state_->work_or_drain.notify_one();
  return true;
}

bool WorkQueue::TryRunHere(const std::function<void()>& task) {
  if (!state_->TakeCaller()) return false;
  state_->Run(task);
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
  return state_->tasks.size() + state_->awaited.size();
}

Clock::duration WorkQueue::IdleFor() const {
  std::lock_guard lock(state_->mutex);
  if (state_->under_way > 0 || !state_->empty()) return Clock::duration::zero();
  if (state_->last_end == Clock::time_point::min()) return Clock::duration::max();
  return Clock::now() - state_->last_end;
}

std::int64_t WorkQueue::failed() const { return state_->failed.load(std::memory_order_relaxed); }

}  // namespace cwm::server
