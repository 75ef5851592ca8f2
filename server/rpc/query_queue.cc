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

// kShort only if the query brings no geometry and uses no engine that may have to prepare it first.
WorkLength LengthForSubject(const v1::Subject& subject, const v1::QueryOptions& options,
                            double cost_s) {
  const bool is_prepared = (subject.has_robot() || subject.has_object()) &&
                           options.overlay().empty() && options.engine() != v1::ENGINE_FCL &&
                           options.engine() != v1::ENGINE_BULLET;
  const bool is_short = RowBytes(subject) <= kMaxShortQueryBytes && cost_s <= kMaxShortQueryCost_s;
  return is_prepared && is_short ? WorkLength::kShort : WorkLength::kAny;
}

}  // namespace

CoreShare::CoreShare(Runtime& runtime, bool is_batch) : runtime_(runtime), is_batch_(is_batch) {
  if (is_batch_) threads_ = std::max(1, runtime.cores / ++runtime.batches_under_way);
}

CoreShare::~CoreShare() {
  if (is_batch_) --runtime_.batches_under_way;
}

WorkLength LengthOf(const v1::CheckCollisionsRequest& request, double cost_s) {
  return LengthForSubject(request.subject(), request.options(), cost_s);
}
WorkLength LengthOf(const v1::GetDistancesRequest& request, double cost_s) {
  return LengthForSubject(request.subject(), request.options(), cost_s);
}

std::size_t RowBytes(const v1::CheckCollisionsRequest& request) {
  return RowBytes(request.subject());
}
std::size_t RowBytes(const v1::GetDistancesRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::GetContactsRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::GetWorldContactsRequest&) { return 0; }
std::size_t RowBytes(const v1::CheckMotionsRequest& request) { return RowBytes(request.subject()); }
std::size_t RowBytes(const v1::SolvePosesRequest& request) {
  return request.x_world_tool().data().size();
}
std::size_t RowBytes(const v1::GetLinkPosesRequest& request) {
  return request.robot().rows().data().size();
}
std::size_t RowBytes(const v1::CastRaysRequest& request) { return request.rays().data().size(); }
std::size_t RowBytes(const v1::SamplePointsRequest& request) {
  return request.points().data().size();
}

}  // namespace cwm::server
