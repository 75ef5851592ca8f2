// Bounded queues and the threads that serve them. Queries, ingests and control have queues of their
// own, so that a cloud never delays a query. Within a queue clients share the threads by cost.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "server/core/fair_tasks.h"
#include "server/core/limits.h"

namespace cwm::server {

struct WorkQueueOptions {
  std::string name;  // shown in thread names and statistics
  int threads = 1;
  std::size_t capacity = 64;         // tasks waiting
  std::size_t awaited_capacity = 0;  // the same for Lane::kAwaited
  int nice = 0;                      // if above 0, its threads yield to others
  // Work that would wait longer is refused when it is pushed, or when its turn comes too late.
  std::chrono::duration<double> max_wait = std::chrono::seconds(5);
};

// Thread safe.
class WorkQueue {
 public:
  explicit WorkQueue(WorkQueueOptions options);
  ~WorkQueue();  // calls Drain

  // Each lane shares fairly among clients and has its own limit. While both have tasks, they are
  // served in turn: a burst of calls that one event releases at most halves the rate of new work,
  // and takes none of its places.
  enum class Lane {
    kNew,      // work that was just received
    kAwaited,  // work that had to wait for an event
  };
  // Runs the task exactly once: in a thread of the queue to do its work, or in the caller's thread
  // with an error if it is refused. Refusals: ResourceExhausted QUEUE_FULL for a full lane in which
  // no other client has more places, or for a wait longer than max_wait; Unavailable
  // SERVER_DRAINING. In a full lane the newest task of the client with the most places is evicted.
  // A task whose turn comes after max_wait is run with QUEUE_FULL, and one that can no longer meet
  // its deadline with DeadlineExceeded DEADLINE_TOO_SHORT. Refusals suggest a time to retry.
  void Push(Task task, Lane lane = Lane::kNew);
  // Pushes the server's own work, without a client or a deadline. False if the lane is full or the
  // queue is draining; then nothing is run. An empty function must not be pushed.
  bool TryPush(std::function<void()> task, Lane lane = Lane::kNew);
  // Runs the task in the caller's thread, in place of a thread of the queue: for tasks that take
  // less time than waking another thread. At most one caller at a time may do so. False, with
  // nothing run, while tasks wait, while all threads are busy, or when draining.
  bool TryRunInline(const std::function<void()>& task);
  // Refuses new tasks and waits until all others are done. Never call it from one of its own tasks.
  void Drain();
  std::size_t waiting() const;  // in both lanes
  // How long the queue has been idle: zero while a task waits or runs, Clock::duration::max()
  // before the first task.
  Clock::duration IdleFor() const;
  // Number of tasks that threw; the exceptions are swallowed, so that no task ends the server.
  std::int64_t failed() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
