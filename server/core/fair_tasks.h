// Tasks that wait, shared fairly among clients: start-time fair queueing (Goyal, Vin and Cheng,
// "Start-time Fair Queueing", IEEE/ACM Transactions on Networking 5, 1997). It shares like deficit
// round robin by cost, in the order of one number and without a quantum: a client with a thousand
// batches delays another by the batch under way and one more.
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
  // Called once: with OK to do the work, else with the error to answer.
  std::function<void(const absl::Status& admitted)> run;
  ClientId client = {};
  double cost_s = 0;  // estimated time of one core
  Clock::time_point deadline = Clock::time_point::max();
  // Work that answers what is complete when its time is over is never too late to begin.
  bool may_answer_in_part = false;
  Clock::time_point pushed = {};  // set by the queue
};

// Not thread safe.
class FairTasks {
 public:
  // A task without an estimate takes a thread's wake and a reply.
  static constexpr double kMinCost_s = 50e-6;

  void Push(Task task);
  // The task whose turn it is. Not when empty.
  Task Pop();
  // The newest task of the client that has most of them, where that is another client with more
  // than `client` would have with one more.
  std::optional<Task> TakeFromLongest(const ClientId& client);

  // A task of the client cost so much more than it was estimated to, or less: its next ones come later
  // for it, or sooner.
  void Correct(const ClientId& client, double cost_s);

  // Whoever used more than a share while nobody else wanted it owes nothing. Only when empty.
  void ForgetDebts() { flows_.clear(); }

  std::size_t size() const { return tasks_.size(); }
  bool empty() const { return tasks_.empty(); }
  // Estimated costs of what is served before a task that `client` would push now.
  double CostBefore(const ClientId& client) const;

 private:
  // Serves by start tag, then in the order of arrival.
  struct Turn {
    double start = 0;
    std::int64_t number = 0;
    friend auto operator<=>(const Turn&, const Turn&) = default;
  };
  struct Flow {
    double start = 0, finish = 0;  // of its newest task
    std::size_t waiting = 0;
  };

  double StartOf(std::int64_t connection) const;
  Task Remove(std::map<Turn, Task>::iterator at);

  std::map<Turn, Task> tasks_;
  std::unordered_map<std::int64_t, Flow> flows_;
  double virtual_time_ = 0;  // start tag of the task that was served last
  std::int64_t last_number_ = 0;
};

}  // namespace cwm::server
