#include "server/rpc/query_queue.h"

#include <algorithm>

namespace cwm::server {
namespace {

std::size_t RowBytes(const v1::Subject& subject) {
  switch (subject.what_case()) {
    case v1::Subject::kShapes:
      return subject.shapes().x_world_body().data().size();
    case v1::Subject::kObject:
      return subject.object().x_world_object().data().size();
    case v1::Subject::kPoints:
      return subject.points().data().size();
    case v1::Subject::kRobot:
      return subject.robot().rows().data().size();
    case v1::Subject::WHAT_NOT_SET:
      break;
  }
  return 0;
}

}  // namespace

ShareOfCores::ShareOfCores(Runtime& runtime, std::size_t row_bytes)
    : runtime_(runtime), is_batch_(row_bytes > kMostBytesOfFew) {
  if (is_batch_) threads_ = std::max(1, runtime.cores / ++runtime.batches_under_way);
}

ShareOfCores::~ShareOfCores() {
  if (is_batch_) --runtime_.batches_under_way;
}

std::size_t RowBytes(const v1::CheckCollisionsRequest& request) {
  return RowBytes(request.subject());
}
std::size_t RowBytes(const v1::GetDistancesRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::GetContactsRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::CheckMotionsRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::CastRaysRequest& request) { return request.rays().data().size(); }
std::size_t RowBytes(const v1::SamplePointsRequest& request) {
  return request.points().data().size();
}

}  // namespace cwm::server
