// The state shared by all services: the application, the queues that do the work, and the calls in
// progress.
#pragma once

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/core/client_id.h"
#include "server/core/fair_quota.h"
#include "server/core/geometry_store.h"
#include "server/core/ingest.h"
#include "server/core/limits.h"
#include "server/core/live/live_worlds.h"
#include "server/core/memory_budget.h"
#include "server/core/store_admin.h"
#include "server/core/work_queue.h"
#include "server/core/world_registry.h"
#include "server/rpc/connections.h"
#include "server/rpc/exported_worlds.h"
#include "server/rpc/open_calls.h"
#include "server/rpc/reply_slowdown.h"
#include "server/rpc/request_log.h"
#include "server/rpc/revision_waits.h"
#include "server/rpc/serving_gate.h"
#include "server/rpc/stall_timers.h"
#include "server/rpc/timer.h"
#include "server/rpc/transport_limits.h"

namespace cwm::server {

inline constexpr char kMemoryStore[] = "memory";

// The application, independent of any transport.
struct Application {
  Limits limits;
  Retention retention;
  Interpreter interpret;
  TransportLimits transport = {};
  std::shared_ptr<MemoryBudget> memory = MemoryBudget::Make(limits.max_memory_bytes);
  WorldRegistry worlds{limits, retention, memory};
  // Blobs that nothing uses yet belong to no world: they may take at most an eighth of the account.
  GeometryStore geometry{std::min(limits.max_geometry_bytes, limits.max_memory_bytes / 8), limits};
  // The place of the worlds: kMemoryStore or "sqlite:PATH".
  std::string store = kMemoryStore;
  // The store, once the worlds are restored; nullptr for kMemoryStore.
  std::atomic<StoreAdmin*> store_admin = nullptr;
  ServingGate gate = {};
};

// A call that may wait for its client without limit, and that a draining server ends.
class Drainable {
 public:
  virtual ~Drainable() = default;
  virtual void Drain() = 0;  // thread safe, does not block
};

// chosen: messages that streams have read while they answer the previous one. Each may have 16 MiB;
// above this number streams read one message after the other.
inline constexpr std::int64_t kMaxReadAhead = 64;

// The most calls that one connection may have open: as many streams and watches as a client may
// have, and some others. gRPC clients silently hold back calls above it, so it is more than the
// services admit: one stream too many is refused with a reason.
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
  OpenCalls open_calls;  // before the queues, whose tasks hold calls
  Timer timer;
  RequestLog log{timer};
  StallTimers stalls{timer};
  // Quotas, each shared among clients. The viewer's watches are those of pages in browsers.
  FairQuota watchers;
  FairQuota viewer_watchers;
  FairQuota streams;
  FairQuota uploads;
  FairQuota read_ahead;  // messages that streams have read ahead
  ExportedWorlds exports;
  ReplySlowdown reply_slowdown;
  RevisionWaits waits;  // before the queues, since queued calls refer to it

  const int cores;

  LiveWorlds live_worlds;  // before the queues, whose tasks use it

  // One queue per class of work. Each has one thread per core, except ingests (one ingest uses
  // every core already), batches, and robots (loaded rarely, in seconds). Much work of one class
  // delays the others by its share of the cores, never by its queue: a read does not wait for a
  // write that prepares geometry.
  WorkQueue query;    // queries of a few rows (query_queue.h)
  WorkQueue batches;  // larger queries and other long work; yields to short work
  WorkQueue ingest;   // its threads yield to all others
  WorkQueue reads;    // reads of worlds, objects, geometry and server state
  WorkQueue writes;
  WorkQueue robots;  // reads robots' files; its thread yields to all others
  WorkQueue watch;
  WorkQueue live;  // frames of running sensors: neither niced nor behind other work

  // Threads that a scan may use at present, at least one: all cores while there are no queries,
  // otherwise all but one, so that a query's thread can wake on a core of its own. measured: with
  // scans on all cores the kernel lets it wait for up to a tick whatever the priorities are (p99 of
  // 3 ms instead of 1.2).
  int ThreadsForScan() const;

  // Returns the memory of deleted worlds to the system, which the allocator would keep. Happens
  // soon, and once for several calls.
  void ScheduleMemoryReturn();

  std::atomic<int> batches_under_way = 0;  // batches being answered

  // Looks from now on, twice a second, for sensors that are gone.
  void WatchSensors();

  // The sender of the call. Must be called when the call begins.
  ClientId ClientOf(const grpc::CallbackServerContext& context) const;

  // True if work of calls, other than watches, waits or runs.
  bool IsBusy() const;

  // Ends streams and half-open uploads now, refuses later calls and those that wait for their turn;
  // watches get their last bookmark.
  void Drain();
  bool draining() const { return draining_; }
  // OK if calls are served; else the reason for which a call that begins now is refused.
  absl::Status CheckServing() const;
  void AddDrainable(std::weak_ptr<Drainable> stream);

 private:
  std::atomic<bool> draining_ = false;
  void ForgetGoneSensors();

  std::atomic<bool> returns_memory_ = false;
  std::atomic<bool> watches_sensors_ = false;
  std::mutex mutex_;
  std::vector<std::weak_ptr<Drainable>> streams_under_way_;
};

}  // namespace cwm::server
