#include "server/core/fair_tasks.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace cwm::server {
namespace {

// chosen: beyond this number, flows without a waiting task are forgotten together with their small
// debts.
constexpr std::size_t kMaxFlows = 1'024;

}  // namespace

double FairTasks::StartOf(std::int64_t connection) const {
  const auto flow = flows_.find(connection);
  return flow == flows_.end() ? virtual_time_ : std::max(virtual_time_, flow->second.finish);
}

void FairTasks::Push(Task task) {
  const std::int64_t connection = task.client.connection;
  double start = StartOf(connection);
  Flow& flow = flows_[connection];
  // A flow that was cheaper than estimated starts its later tasks sooner, but never before its
  // waiting ones.
  if (flow.waiting > 0) start = std::max(start, flow.start);
  flow.start = start;
  flow.finish = start + std::max(task.cost_s, kMinCost_s);
  ++flow.waiting;
  tasks_.emplace(Turn{start, ++last_number_}, std::move(task));
}

Task FairTasks::Remove(std::map<Turn, Task>::iterator at) {
  Task task = std::move(at->second);
  tasks_.erase(at);
  --flows_[task.client.connection].waiting;
  if (flows_.size() > kMaxFlows) {
    std::erase_if(flows_, [](const auto& flow) { return flow.second.waiting == 0; });
  }
  return task;
}

Task FairTasks::Pop() {
  virtual_time_ = tasks_.begin()->first.start;
  return Remove(tasks_.begin());
}

std::optional<Task> FairTasks::TakeFromLongest(const ClientId& client) {
  const auto own = flows_.find(client.connection);
  const std::size_t mine = own == flows_.end() ? 0 : own->second.waiting;
  const auto longest = std::max_element(
      flows_.begin(), flows_.end(),
      [](const auto& a, const auto& b) { return a.second.waiting < b.second.waiting; });
  if (longest == flows_.end() || longest->second.waiting <= mine + 1) return std::nullopt;
  for (auto at = tasks_.end(); at != tasks_.begin();) {
    --at;
    if (at->second.client.connection != longest->first) continue;
    longest->second.finish = at->first.start;  // as if it had never been pushed
    return Remove(at);
  }
  return std::nullopt;
}

void FairTasks::Correct(const ClientId& client, double cost_s) {
  flows_[client.connection].finish = StartOf(client.connection) + cost_s;
}

double FairTasks::CostBefore(const ClientId& client) const {
  const double start = StartOf(client.connection);
  double cost_s = 0;
  for (const auto& [turn, task] : tasks_) {
    if (turn.start > start) break;
    cost_s += std::max(task.cost_s, kMinCost_s);
  }
  return cost_s;
}

}  // namespace cwm::server
