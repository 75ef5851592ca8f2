// Bounded queues and the threads that serve them: queries, ingests and control each have their own,
// so that a cloud never delays a query.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

namespace cwm::server {

struct WorkQueueOptions {
  std::string name;  // shown in thread names and statistics
  int threads = 1;
  std::size_t capacity = 64;  // tasks waiting
  int nice = 0;               // 10 for ingests: their threads yield to queries
};

// Thread safe.
class WorkQueue {
 public:
  explicit WorkQueue(WorkQueueOptions options);
  ~WorkQueue();  // Drains

  // False when the queue is full or draining: the caller answers RESOURCE_EXHAUSTED with a retry
  // time.
  bool TryPush(std::function<void()> task);
  // Refuses new tasks and waits for the rest.
  void Drain();
  std::size_t waiting() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace cwm::server
