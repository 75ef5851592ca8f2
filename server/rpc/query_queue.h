// Which queue answers a question, and on how many threads: a few rows are answered at once,
// whatever batches are under way.
#pragma once

#include <cstddef>

#include "cwm/v1/query.pb.h"
#include "server/rpc/call.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Questions with more bytes of rows are batches: 64 states of an arm or poses, which take some
// milliseconds at most.
inline constexpr std::size_t kMostBytesOfFew = 4096;

// So few states or poses of what the server has already, nine of an arm, are asked about within some
// hundred microseconds: what waking a thread takes.
inline constexpr std::size_t kMostBytesOfShort = 512;

// Bytes of the rows that the question asks about.
std::size_t RowBytes(const v1::CheckCollisionsRequest& request);
std::size_t RowBytes(const v1::GetDistancesRequest& request);
std::size_t RowBytes(const v1::GetContactsRequest& request);
std::size_t RowBytes(const v1::CheckMotionsRequest& request);
std::size_t RowBytes(const v1::CastRaysRequest& request);
std::size_t RowBytes(const v1::SamplePointsRequest& request);

// Seconds of one core that an answer takes, by a rule of thumb: queues share by it.
template <class Request>
double EstimatedCost_s(const Request& request) {
  constexpr double kOfByte_s =
      20e-9;  // some states of an arm in a kitchen, 56 bytes each, take 1 us
  return kOfByte_s * static_cast<double>(RowBytes(request));
}

// How long an answer takes, if that is known to be short.
WorkLength LengthOf(const v1::CheckCollisionsRequest& request);
WorkLength LengthOf(const v1::GetDistancesRequest& request);
template <class Request>
WorkLength LengthOf(const Request&) {
  return WorkLength::kAny;
}

// While it lives a question is being answered; how many threads may do it. One alone has all cores,
// several have each their share.
class ShareOfCores {
 public:
  ShareOfCores(Runtime& runtime, std::size_t row_bytes);
  ~ShareOfCores();
  ShareOfCores(const ShareOfCores&) = delete;
  ShareOfCores& operator=(const ShareOfCores&) = delete;

  int threads() const { return threads_; }

 private:
  Runtime& runtime_;
  const bool is_batch_;
  int threads_ = 1;
};

template <class Request>
WorkQueue& QueueOf(Runtime& runtime, const Request& request) {
  return RowBytes(request) > kMostBytesOfFew ? runtime.batches : runtime.query;
}

}  // namespace cwm::server
