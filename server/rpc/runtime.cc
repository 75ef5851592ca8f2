#include "server/rpc/runtime.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "server/core/heap_memory.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

constexpr std::size_t kQueryCapacity = 64;
constexpr std::size_t kIngestCapacity = 8;
constexpr std::size_t kRobotCapacity = 8;
constexpr std::size_t kReadCapacity = 64;
constexpr std::size_t kWriteCapacity = 64;

// chosen: a scan uses every core by itself, so two at once would each take twice as long.
constexpr int kScansAtOnce = 1;

// chosen: queries come in bursts, from a control loop or a planner; within a burst the next query
// comes sooner than this.
constexpr auto kPauseOfQueries = std::chrono::milliseconds(500);

// chosen: batches that share a core; further ones wait. With more of them the core is shared more
// evenly, but more answers are in memory at a time.
constexpr int kBatchesOfCore = 2;

// chosen: a scan or a robot takes up to some seconds, and its client has spent as long on sending
// it.
constexpr auto kMaxWaitOfUploads = std::chrono::seconds(30);

// The viewer's pages all come from this process, as one client.
constexpr double kUnshared = std::numeric_limits<double>::infinity();

std::size_t AwaitedCapacity(const Limits& limits) {
  return static_cast<std::size_t>(limits.max_waits);
}

// Each stream has at most two tasks at a time.
std::size_t LiveCapacity(const Limits& limits) {
  return static_cast<std::size_t>(2 * limits.max_streams);
}

int Cores() { return static_cast<int>(std::max(1U, std::thread::hardware_concurrency())); }

}  // namespace

Runtime::Runtime(Application& application_in)
    : application(application_in),
      connections(ConnectionLimits::Fit(application.transport, MaxDescriptors()), MaxDescriptors()),
      watchers({.limit = application.limits.max_watchers,
                .member_limit = application.limits.max_client_watchers}),
      viewer_watchers({.limit = application.limits.max_viewer_watchers,
                       .group_share = kUnshared,
                       .member_share = kUnshared}),
      streams({.limit = application.limits.max_streams,
               .member_limit = application.limits.max_client_streams}),
      uploads({.limit = application.limits.max_uploads,
               .member_limit = application.limits.max_client_uploads}),
      read_ahead({.limit = kMaxReadAhead, .member_share = 1}),
      waits(timer, {.limit = application.limits.max_waits,
                    .member_limit = application.limits.max_client_waits}),
      cores(Cores()),
      live_worlds(
          {.interpret = application.interpret,
           .run_beside =
               [this](std::function<void()> task) { return ingest.TryPush(std::move(task)); },
           .max_threads = cores,
           .threads_now = [this] { return ThreadsForScan(); }}),
      query({.name = "query",
             .threads = cores,
             .capacity = kQueryCapacity,
             .awaited_capacity = AwaitedCapacity(application.limits),
             .max_wait = application.limits.max_queue_wait}),
      batches({.name = "batches",
               .threads = kBatchesOfCore * cores,
               .capacity = kQueryCapacity,
               .awaited_capacity = AwaitedCapacity(application.limits),
               .nice = 3,
               .max_wait = application.limits.max_queue_wait}),
      // A lower priority, but not starved by other programs of the robot: on a shared core it gets
      // a quarter.
      ingest({.name = "ingest",
              .threads = kScansAtOnce,
              .capacity = kIngestCapacity,
              .nice = 5,
              .max_wait = kMaxWaitOfUploads}),
      reads({.name = "reads",
             .threads = cores,
             .capacity = kReadCapacity,
             .awaited_capacity = AwaitedCapacity(application.limits),
             .max_wait = application.limits.max_queue_wait}),
      writes({.name = "writes",
              .threads = cores,
              .capacity = kWriteCapacity,
              .max_wait = application.limits.max_queue_wait}),
      robots({.name = "robots",
              .threads = 1,
              .capacity = kRobotCapacity,
              .nice = 5,
              .max_wait = kMaxWaitOfUploads}),
      // Each watch has at most one waiting task, so that none is ever refused.
      watch({.name = "watch",
             .threads = cores,
             .capacity = static_cast<std::size_t>(application.limits.max_watchers +
                                                  application.limits.max_viewer_watchers) +
                         1}),
      live({.name = "live",
            .threads = cores,
            .capacity = LiveCapacity(application.limits),
            .max_wait = application.limits.max_queue_wait}) {
  application.worlds.SetListener([this](const World& world, WorldRegistry::WorldEvent event) {
    if (event == WorldRegistry::WorldEvent::kCreated) {
      log.WorldCreated(world.name(), world.uid());
    } else {
      log.WorldDeleted(world.name(), world.uid());
      live_worlds.Forget(world);
    }
  });
}

// The timer is stopped first, since its last task may be about to use a queue.
Runtime::~Runtime() {
  application.worlds.SetListener({});
  timer.Stop();
}

int Runtime::ThreadsForScan() const {
  const auto idle = std::min(query.IdleFor(), batches.IdleFor());
  return idle > kPauseOfQueries ? cores : std::max(1, cores - 1);
}

void Runtime::ScheduleMemoryReturn() {
  if (returns_memory_.exchange(true)) return;
  // By then the readers of deleted worlds have released them.
  constexpr auto kDelay = std::chrono::milliseconds(500);
  timer.After(kDelay, [this] {
    const bool is_taken = robots.TryPush([this] {
      returns_memory_ = false;
      application.geometry.DropUnused();
      ReturnFreedMemory();
    });
    if (!is_taken) returns_memory_ = false;
  });
}

void Runtime::WatchSensors() {
  if (!watches_sensors_.exchange(true)) ForgetGoneSensors();
}

void Runtime::ForgetGoneSensors() {
  constexpr auto kPeriod = std::chrono::milliseconds(500);
  timer.After(kPeriod, [this] {
    // In a queue, since it may wait for a frame or for the disk.
    live.TryPush([this] {
      if (live_worlds.ForgetGone(Clock::now())) ScheduleMemoryReturn();
    });
    ForgetGoneSensors();
  });
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
  const std::initializer_list<const WorkQueue*> queues = {&query,  &batches, &ingest, &reads,
                                                          &writes, &robots,  &live};
  return std::any_of(queues.begin(), queues.end(), is_busy);
}

absl::Status Runtime::CheckServing() const {
  return draining_ ? Draining() : application.gate.Check();
}

void Runtime::AddDrainable(std::weak_ptr<Drainable> stream) {
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(streams_under_way_, [](const auto& known) { return known.expired(); });
    streams_under_way_.push_back(stream);
  }
  // Drain may have run just before the stream was added.
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
