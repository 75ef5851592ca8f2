// Selects the queue and the number of threads for a query or a write, so that short work is done at
// once whatever batches are in progress.
#pragma once

#include <cstddef>

#include "cwm/v1/query.pb.h"
#include "cwm/v1/robot.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/runtime.h"
#include "server/wire/request_cost.h"

namespace cwm::server {

// chosen: queries with more bytes of rows are batches: 64 states of an arm, or so many poses, take
// a few milliseconds at most.
inline constexpr std::size_t kMaxSmallQueryBytes = 4096;

// chosen: so few states or poses of a known body (nine states of an arm) take some hundred
// microseconds, about as long as waking a thread.
inline constexpr std::size_t kMaxShortQueryBytes = 512;

// chosen: a query with a higher estimate is a batch, too, however few rows it has: it brings a mesh
// that must be prepared, or the world has heavy objects.
inline constexpr double kMaxSmallQueryCost_s = 20e-3;
// chosen: the highest estimate of a query that is answered by the thread that read it: nine states
// of an arm among a hundred objects are estimated at 0.3 ms, their distances at 1 ms.
inline constexpr double kMaxShortQueryCost_s = 2e-3;

// Bytes of the query's rows.
std::size_t RowBytes(const v1::CheckCollisionsRequest& request);
std::size_t RowBytes(const v1::GetDistancesRequest& request);
std::size_t RowBytes(const v1::GetContactsRequest& request);
std::size_t RowBytes(const v1::GetWorldContactsRequest& request);
std::size_t RowBytes(const v1::CheckMotionsRequest& request);
std::size_t RowBytes(const v1::SolvePosesRequest& request);
std::size_t RowBytes(const v1::GetLinkPosesRequest& request);
std::size_t RowBytes(const v1::CastRaysRequest& request);
std::size_t RowBytes(const v1::SamplePointsRequest& request);

// Estimated CPU seconds of one core for the request in the world's latest snapshot. Takes a few
// microseconds and is called before the request is queued.
template <class Request>
double EstimatedCost_s(const Runtime& runtime, const Request& request) {
  const auto world = runtime.application.worlds.Find(request.world(), "");
  const SnapshotPtr snapshot = world.ok() ? (*world)->Snapshot() : nullptr;
  return EstimatedCost_s(request, CostSource{runtime.application.geometry, snapshot.get()});
}

// kShort if the answer is known to take little time; `cost_s` is the estimate.
WorkLength LengthOf(const v1::CheckCollisionsRequest& request, double cost_s);
WorkLength LengthOf(const v1::GetDistancesRequest& request, double cost_s);
template <class Request>
WorkLength LengthOf(const Request&, double) {
  return WorkLength::kAny;
}

template <class Request>
bool IsBatch(const Request& request, double cost_s) {
  return RowBytes(request) > kMaxSmallQueryBytes || cost_s > kMaxSmallQueryCost_s;
}
template <class Request>
bool IsBatch(const Runtime& runtime, const Request& request) {
  return RowBytes(request) > kMaxSmallQueryBytes ||
         EstimatedCost_s(runtime, request) > kMaxSmallQueryCost_s;
}

// Exists while a query is being answered and sets the number of its threads: a single batch has all
// cores, several share them evenly.
class CoreShare {
 public:
  CoreShare(Runtime& runtime, bool is_batch);
  ~CoreShare();
  CoreShare(const CoreShare&) = delete;
  CoreShare& operator=(const CoreShare&) = delete;

  int threads() const { return threads_; }

 private:
  Runtime& runtime_;
  const bool is_batch_;
  int threads_ = 1;
};

// Long writes share the cores with batches, so that they do not delay short writes.
inline WorkQueue& WriteQueueFor(Runtime& runtime, double cost_s) {
  return cost_s > kMaxSmallQueryCost_s ? runtime.batches : runtime.writes;
}

template <class Request>
WorkQueue& QueueOf(Runtime& runtime, const Request& request, double cost_s) {
  return IsBatch(request, cost_s) ? runtime.batches : runtime.query;
}

}  // namespace cwm::server
