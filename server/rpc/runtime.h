// What the services share: the application, the queues that do the work, and what is going on right
// now.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <vector>

#include "absl/status/statusor.h"
#include "server/core/geometry_store.h"
#include "server/core/ingest.h"
#include "server/core/limits.h"
#include "server/core/work_queue.h"
#include "server/core/world_registry.h"
#include "server/rpc/timer.h"

namespace cwm::server {

// The application behind every transport.
struct Application {
  Limits limits;
  Retention retention;
  Interpreter interpret;
  WorldRegistry worlds{limits, retention};
  GeometryStore geometry{limits.max_geometry_bytes};
};

// Counts what may only be so many.
class Quota {
 public:
  explicit Quota(std::int64_t most) : most_(most) {}

  bool TryTake(std::int64_t amount = 1);
  void GiveBack(std::int64_t amount = 1) { taken_ -= amount; }
  std::int64_t taken() const { return taken_; }
  std::int64_t most() const { return most_; }

 private:
  const std::int64_t most_;
  std::atomic<std::int64_t> taken_ = 0;
};

// A stream without an end of its own, which a draining server ends.
class Drainable {
 public:
  virtual ~Drainable() = default;
  virtual void Drain() = 0;  // thread safe, does not block
};

// Bytes of uploads under way, all together: three clouds of 20 M points at 32 bytes.
inline constexpr std::int64_t kMaxUploadBytes = std::int64_t{2} << 30;

// Thread safe.
class Runtime {
 public:
  explicit Runtime(Application& application);
  ~Runtime();

  Application& application;
  Timer timer;
  Quota watchers;
  Quota streams;
  Quota upload_bytes{kMaxUploadBytes};

  const int cores;

  // One queue per class of work, each with a thread per core but the ingests', of which one already
  // uses every core. A crowd of one class delays the others by its share of the cores, never by its
  // queue: a read does not wait for a write that prepares geometry.
  WorkQueue query;
  WorkQueue ingest;  // its threads yield to all others
  WorkQueue reads;   // of worlds, objects, geometry, the server
  WorkQueue writes;
  WorkQueue watch;

  // Threads that a scan may keep busy just now, at least one: every core while nobody asks, all but
  // one while queries come. A query's thread can wake on a core of its own then; with scans on all
  // of them the kernel lets it wait for up to a tick whatever the priorities are (p99 of 3 ms
  // against 1.2).
  int ThreadsForScan() const;

  // Calls `then` from some thread, once: with the world's snapshot as soon as it has the revision,
  // else with the world's end, DeadlineExceeded or Cancelled. Blocks nobody.
  using Then = std::function<void(absl::StatusOr<SnapshotPtr>)>;
  void WhenReached(std::shared_ptr<World> world, collision::Revision revision,
                   Clock::time_point deadline, std::stop_token stop, Then then);

  // Ends streams now and uploads to come; watches get their last bookmark.
  void Drain();
  bool draining() const { return draining_; }
  void AddDrainable(std::weak_ptr<Drainable> stream);

 private:
  struct RevisionWait;
  void Poll(std::shared_ptr<RevisionWait> wait);

  std::atomic<bool> draining_ = false;
  Quota waits_;
  std::mutex mutex_;
  std::vector<std::weak_ptr<Drainable>> streams_under_way_;
};

}  // namespace cwm::server
