#include "server/rpc/runtime.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

namespace cwm::server {
namespace {

// Queued work holds its request: at 16 MiB a message these bound the memory.
constexpr std::size_t kQueryCapacity = 64;
constexpr std::size_t kIngestCapacity = 8;
constexpr std::size_t kRobotCapacity = 8;
constexpr std::size_t kReadCapacity = 64;
constexpr std::size_t kWriteCapacity = 64;

// A scan spreads over every core by itself: two at once would each take twice as long.
constexpr int kScansAtOnce = 1;

// Queries come in streaks: a control loop, a planner. Within one, the next is closer than this.
constexpr auto kPauseOfQueries = std::chrono::milliseconds(500);

// Batches that share a core: further ones wait for their turn. More of them share it more evenly,
// and hold more answers at a time.
constexpr int kBatchesOfCore = 2;

int Cores() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

}  // namespace

Runtime::Runtime(Application& application_in)
    : application(application_in),
      connections(ConnectionLimits::Fit(application.transport, MaxDescriptors()), MaxDescriptors()),
      watchers(application.limits.max_watchers),
      viewer_watchers(application.limits.max_viewer_watchers),
      streams(application.limits.max_streams),
      cores(Cores()),
      query({.name = "query",
             .threads = cores,
             .capacity = kQueryCapacity,
             .awaited_capacity = kMaxWaits}),
      batches({.name = "batches",
               .threads = kBatchesOfCore * cores,
               .capacity = kQueryCapacity,
               .awaited_capacity = kMaxWaits}),
      // Lower, yet not starved by what else runs on a robot: a quarter of a core that it must
      // share.
      ingest({.name = "ingest", .threads = kScansAtOnce, .capacity = kIngestCapacity, .nice = 5}),
      reads({.name = "reads",
             .threads = cores,
             .capacity = kReadCapacity,
             .awaited_capacity = kMaxWaits}),
      writes({.name = "writes", .threads = cores, .capacity = kWriteCapacity}),
      robots({.name = "robots", .threads = 1, .capacity = kRobotCapacity, .nice = 5}),
      // Each watch has one task waiting at most, so that none is ever refused.
      watch({.name = "watch",
             .threads = cores,
             .capacity = static_cast<std::size_t>(application.limits.max_watchers +
                                                  application.limits.max_viewer_watchers) +
                         1}) {}

// Its last task may be about to wake a queue.
Runtime::~Runtime() { timer.Stop(); }

int Runtime::ThreadsForScan() const {
  const auto idle = std::min(query.IdleFor(), batches.IdleFor());
  return idle > kPauseOfQueries ? cores : std::max(1, cores - 1);
}

ClientId Runtime::ClientOf(const grpc::CallbackServerContext& context) const {
  const std::string peer = context.peer();
  // Calls from this process have no address such as "fd:1031".
  if (peer.find(':') == std::string::npos) return {};
  constexpr std::string_view kPrefix = "fd:";
  int number = -1;
  if (peer.starts_with(kPrefix)) {
    std::from_chars(peer.data() + kPrefix.size(), peer.data() + peer.size(), number);
  }
  return connections.Find(number);
}

bool Runtime::IsBusy() const {
  const auto is_busy = [](const WorkQueue* queue) {
    return queue->IdleFor() == Clock::duration::zero();
  };
  const std::initializer_list<const WorkQueue*> queues = {&query, &batches, &ingest,
                                                          &reads, &writes,  &robots};
  return std::any_of(queues.begin(), queues.end(), is_busy);
}

void Runtime::AddDrainable(std::weak_ptr<Drainable> stream) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(streams_under_way_, [](const auto& known) { return known.expired(); });
    streams_under_way_.push_back(stream);
  }
  // Drain may just have taken its look.
  if (draining_) {
    if (const auto living = stream.lock()) living->Drain();
  }
}

void Runtime::Drain() {
  draining_ = true;
  open_calls.SetDraining();
  waits.Drain();
  application.worlds.Drain();
  std::vector<std::weak_ptr<Drainable>> under_way;
  {
    const std::lock_guard lock(mutex_);
    under_way.swap(streams_under_way_);
  }
  for (const auto& stream : under_way) {
    if (const auto living = stream.lock()) living->Drain();
  }
}

}  // namespace cwm::server
