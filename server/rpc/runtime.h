// What the services share: the application, the queues that do the work, and what is going on right
// now.
#pragma once

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "server/core/client_id.h"
#include "server/core/fair_quota.h"
#include "server/core/geometry_store.h"
#include "server/core/ingest.h"
#include "server/core/limits.h"
#include "server/core/memory_budget.h"
#include "server/core/work_queue.h"
#include "server/core/world_registry.h"
#include "server/rpc/connections.h"
#include "server/rpc/exported_worlds.h"
#include "server/rpc/open_calls.h"
#include "server/rpc/reply_pace.h"
#include "server/rpc/request_log.h"
#include "server/rpc/revision_waits.h"
#include "server/rpc/stall_timers.h"
#include "server/rpc/timer.h"
#include "server/rpc/transport_limits.h"

namespace cwm::server {

// The application behind every transport.
struct Application {
  Limits limits;
  Retention retention;
  Interpreter interpret;
  TransportLimits transport = {};
  std::shared_ptr<MemoryBudget> memory = MemoryBudget::Make(limits.max_memory_bytes);
  WorldRegistry worlds{limits, retention, memory};
  // Blobs that nothing uses yet are no world's: they get an eighth of the account at most.
  GeometryStore geometry{std::min(limits.max_geometry_bytes, limits.max_memory_bytes / 8), limits};
};

// A call that may wait for its client without end, which a draining server ends.
class Drainable {
 public:
  virtual ~Drainable() = default;
  virtual void Drain() = 0;  // thread safe, does not block
};

// Messages that streams have read while they answer the one before. Each may have 16 MiB; without
// room for more, streams read one after the other.
inline constexpr std::int64_t kMaxReadAhead = 64;

// Calls that one connection may have open: as many streams and watches as there may be, and others
// beside them. A client keeps back what is above, without a word, so that it is more than the
// services admit: the one stream too many is refused with a reason.
inline std::int64_t MaxCallsOfConnection(const Limits& limits) {
  constexpr std::int64_t kOthers = 128;
  return limits.max_client_streams + limits.max_client_watchers + kOthers;
}

// Thread safe.
class Runtime {
 public:
  explicit Runtime(Application& application);
  ~Runtime();

  Application& application;
  Connections connections;
  OpenCalls open_calls;  // before the queues, which hold calls
  Timer timer;
  RequestLog log{timer};
  StallTimers stalls{timer};
  // Each shared among clients. The viewer's watches are those of pages that browsers show.
  FairQuota watchers;
  FairQuota viewer_watchers;
  FairQuota streams;
  FairQuota uploads;
  FairQuota read_ahead;  // messages of streams
  ExportedWorlds exports;
  ReplyPace reply_pace;
  RevisionWaits waits;  // before the queues: what waited there refers to it

  const int cores;

  // One queue per class of work, each with a thread per core but the ingests', of which one already
  // uses every core, the batches', and the robots', which are loaded rarely and take seconds. A
  // crowd of one class delays the others by its share of the cores, never by its queue: a read does
  // not wait for a write that prepares geometry.
  WorkQueue query;    // questions of a few rows (query_queue.h)
  WorkQueue batches;  // of more, and whatever takes long; its threads yield to short work
  WorkQueue ingest;   // its threads yield to all others
  WorkQueue reads;    // of worlds, objects, geometry, the server
  WorkQueue writes;
  WorkQueue robots;  // files of robots being read; its thread yields to all others
  WorkQueue watch;

  // Threads that a scan may keep busy just now, at least one: every core while nobody asks, all but
  // one while queries come. A query's thread can wake on a core of its own then; with scans on all
  // of them the kernel lets it wait for up to a tick whatever the priorities are (p99 of 3 ms
  // against 1.2).
  int ThreadsForScan() const;

  // Gives back to the system what deleted worlds held, soon and once for many that ask: the
  // allocator keeps it else.
  void ReturnMemorySoon();

  std::atomic<int> batches_under_way = 0;  // that are being answered

  // Who sends the call; ask when the call begins.
  ClientId ClientOf(const grpc::CallbackServerContext& context) const;

  // Work of calls waits or is under way.
  bool IsBusy() const;

  // Ends streams and half-open uploads now, refuses the calls to come and those that wait for their
  // turn; watches get their last bookmark.
  void Drain();
  bool draining() const { return draining_; }
  void AddDrainable(std::weak_ptr<Drainable> stream);

 private:
  std::atomic<bool> draining_ = false;
  std::atomic<bool> returns_memory_ = false;
  std::mutex mutex_;
  std::vector<std::weak_ptr<Drainable>> streams_under_way_;
};

}  // namespace cwm::server
