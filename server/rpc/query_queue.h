// Which queue answers a question or does a write, and on how many threads: what is short is done at
// once, whatever batches are under way.
#pragma once

#include <cstddef>

#include "cwm/v1/query.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/runtime.h"
#include "server/wire/request_cost.h"

namespace cwm::server {

// Questions with more bytes of rows are batches: 64 states of an arm or poses, which take some
// milliseconds at most.
inline constexpr std::size_t kMostBytesOfFew = 4096;

// So few states or poses of what the server has already, nine of an arm, are asked about within
// some hundred microseconds: what waking a thread takes.
inline constexpr std::size_t kMostBytesOfShort = 512;

// A question that is estimated to take more is a batch as well, however few rows it has: it brings
// a mesh that nobody has prepared, or asks in a world of heavy objects.
inline constexpr double kMaxCostOfFew_s = 20e-3;
// Nor is one answered by the thread that read it: nine states of an arm among a hundred objects are
// estimated at 0.3 ms, their distances at 1 ms.
inline constexpr double kMaxCostOfShort_s = 2e-3;

// Bytes of the rows that the question asks about.
std::size_t RowBytes(const v1::CheckCollisionsRequest& request);
std::size_t RowBytes(const v1::GetDistancesRequest& request);
std::size_t RowBytes(const v1::GetContactsRequest& request);
std::size_t RowBytes(const v1::CheckMotionsRequest& request);
std::size_t RowBytes(const v1::CastRaysRequest& request);
std::size_t RowBytes(const v1::SamplePointsRequest& request);

// CPU seconds of one core that the request is estimated to take of the world as it is now. A few
// microseconds, before the request is put into a queue.
template <class Request>
double EstimatedCost_s(const Runtime& runtime, const Request& request) {
  const auto world = runtime.application.worlds.Find(request.world(), "");
  const SnapshotPtr snapshot = world.ok() ? (*world)->Snapshot() : nullptr;
  return EstimatedCost_s(request, CostSource{runtime.application.geometry, snapshot.get()});
}

// How long an answer takes, if that is known to be short; `cost_s` is the estimate.
WorkLength LengthOf(const v1::CheckCollisionsRequest& request, double cost_s);
WorkLength LengthOf(const v1::GetDistancesRequest& request, double cost_s);
template <class Request>
WorkLength LengthOf(const Request&, double) {
  return WorkLength::kAny;
}

template <class Request>
bool IsBatch(const Request& request, double cost_s) {
  return RowBytes(request) > kMostBytesOfFew || cost_s > kMaxCostOfFew_s;
}
template <class Request>
bool IsBatch(const Runtime& runtime, const Request& request) {
  return RowBytes(request) > kMostBytesOfFew || EstimatedCost_s(runtime, request) > kMaxCostOfFew_s;
}

// While it lives a question is being answered; how many threads may do it. One alone has all cores,
// several have each their share.
class ShareOfCores {
 public:
  ShareOfCores(Runtime& runtime, bool is_batch);
  ~ShareOfCores();
  ShareOfCores(const ShareOfCores&) = delete;
  ShareOfCores& operator=(const ShareOfCores&) = delete;

  int threads() const { return threads_; }

 private:
  Runtime& runtime_;
  const bool is_batch_;
  int threads_ = 1;
};

// Writes that take long do not stand before those that do not: they share the cores with batches.
inline WorkQueue& WriteQueueFor(Runtime& runtime, double cost_s) {
  return cost_s > kMaxCostOfFew_s ? runtime.batches : runtime.writes;
}

template <class Request>
WorkQueue& QueueOf(Runtime& runtime, const Request& request, double cost_s) {
  return IsBatch(request, cost_s) ? runtime.batches : runtime.query;
}

}  // namespace cwm::server
