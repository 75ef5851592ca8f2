// Waiting tasks, shared fairly among clients by start-time fair queueing (Goyal, Vin and Cheng,
// "Start-time Fair Queueing", IEEE/ACM Transactions on Networking 5, 1997). It shares by cost like
// deficit round robin, but orders tasks by a single number and needs no quantum: a client with a
// thousand batches delays another client by the batch in progress and one more.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>

#include "absl/status/status.h"
#include "server/core/client_id.h"
#include "server/core/limits.h"

namespace cwm::server {

struct Task {
  // Called once: with OK to do the work, otherwise with the error to answer.
  std::function<void(const absl::Status& admitted)> run;
  ClientId client = {};
  double cost_s = 0;  // estimated time on one core
  Clock::time_point deadline = Clock::time_point::max();
  // True if the work can return partial results when its time is over: then it is never too late to
  // begin.
  bool allows_partial_answer = false;
  Clock::time_point pushed = {};  // set by the queue
};

// Not thread safe.
class FairTasks {
 public:
  // chosen: the least cost of a task: waking a thread and sending a reply.
  static constexpr double kMinCost_s = 50e-6;

  void Push(Task task);
  // Removes and returns the task whose turn it is. Must not be called when empty.
  Task Pop();
  // Removes and returns the newest task of the client with the most tasks. Empty unless that is
  // another client and has more tasks than `client` would have with one more.
  std::optional<Task> TakeFromLongest(const ClientId& client);

  // Adds to the client's account the difference between a task's true and estimated cost (negative
  // if it was cheaper): its next tasks start later, or sooner.
  void Correct(const ClientId& client, double cost_s);

  // Forgets what clients owe for using more than their share while nobody else wanted it. Only when
  // empty.
  void ForgetDebts() { flows_.clear(); }

  std::size_t size() const { return tasks_.size(); }
  bool empty() const { return tasks_.empty(); }
  // The sum of the estimated costs of the tasks served before one that `client` would push now.
  double CostBefore(const ClientId& client) const;

 private:
  // Tasks are served by start tag, then in order of arrival.
  struct Turn {
    double start = 0;
    std::int64_t number = 0;
    friend auto operator<=>(const Turn&, const Turn&) = default;
  };
  struct Flow {
    double start = 0, finish = 0;  // tags of its newest task
    std::size_t waiting = 0;
  };

  double StartOf(std::int64_t connection) const;
  Task Remove(std::map<Turn, Task>::iterator at);

  std::map<Turn, Task> tasks_;
  std::unordered_map<std::int64_t, Flow> flows_;
  double virtual_time_ = 0;  // start tag of the task served last
  std::int64_t last_number_ = 0;
};

}  // namespace cwm::server
