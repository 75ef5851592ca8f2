// Bounded queues and the threads that serve them: queries, ingests and control each have their own,
// so that a cloud never delays a query. Within a queue clients share the threads by cost.
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
  std::size_t awaited_capacity = 0;  // the same of Lane::kAwaited
  int nice = 0;                      // above 0: its threads yield to others
  // Work that would wait longer is refused when it comes, or else when its turn comes too late.
  std::chrono::duration<double> max_wait = std::chrono::seconds(5);
};

// Thread safe.
class WorkQueue {
 public:
  explicit WorkQueue(WorkQueueOptions options);
  ~WorkQueue();  // Drains

  // Each lane shares fairly among clients and has its own limit. While both have tasks, they are
  // served in turn: a crowd that one event sets off delays what comes meanwhile by half, and takes
  // nobody's place.
  enum class Lane {
    kNew,      // what has just come
    kAwaited,  // what had to wait for an event before it could be worked on
  };
  // The task is run once in any case, in a thread of the queue to do its work. It is run in the
  // caller's thread with an error when it is refused: ResourceExhausted QUEUE_FULL for a full lane
  // in which no other client has more places, or for a wait longer than max_wait; Unavailable
  // SERVER_DRAINING. In a full lane the newest task of the client with most places makes room. A
  // task whose turn comes after max_wait is run with QUEUE_FULL, one that cannot meet its deadline
  // any more with DeadlineExceeded DEADLINE_TOO_SHORT. Refusals have the time to retry.
  void Push(Task task, Lane lane = Lane::kNew);
  // Work of the server's own, of no client and without a deadline. False when the lane is full or
  // the queue draining, and nothing is run then. An empty function must not be pushed.
  bool TryPush(std::function<void()> task, Lane lane = Lane::kNew);
  // Runs the task in the caller's thread, in place of one of the queue's: for what takes less than
  // waking another thread. One caller at a time is lent so, and none while others wait or all
  // threads are at work, or when draining: false then, and nothing was run.
  bool TryRunHere(const std::function<void()>& task);
  // Refuses new tasks and waits for the rest, which are done. Never from one of its own tasks.
  void Drain();
  std::size_t waiting() const;  // in both lanes
  // How long nothing has been waiting or under way: zero while something is, Clock::duration::max()
  // before the first task.
  Clock::duration IdleFor() const;
  // Tasks that ended in an exception: it is swallowed, so that one bad task never ends the server.
  std::int64_t failed() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
