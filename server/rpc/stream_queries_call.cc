#include "server/rpc/stream_queries_call.h"

#include <utility>

#include "server/core/error.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/query_queue.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// Calls `use` with the question's message; `otherwise` when there is none.
template <class Use, class Result>
Result WithQuery(const v1::StreamQueriesRequest& request, const Use& use, Result otherwise) {
  switch (request.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return use(request.check_collisions());
    case v1::StreamQueriesRequest::kGetDistances:
      return use(request.get_distances());
    case v1::StreamQueriesRequest::kGetContacts:
      return use(request.get_contacts());
    case v1::StreamQueriesRequest::kCastRays:
      return use(request.cast_rays());
    case v1::StreamQueriesRequest::kSamplePoints:
      return use(request.sample_points());
    case v1::StreamQueriesRequest::kCheckMotions:
      return use(request.check_motions());
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return otherwise;
}

double CostOf(const Runtime& runtime, const v1::StreamQueriesRequest& request) {
  const std::string world = WithQuery(
      request, [](const auto& query) { return query.world(); }, request.overlay().world());
  const auto found = runtime.application.worlds.Find(world, "");
  const SnapshotPtr snapshot = found.ok() ? (*found)->Snapshot() : nullptr;
  return EstimatedCost_s(request, {runtime.application.geometry, snapshot.get()});
}

using MaybeAwait = absl::StatusOr<std::optional<RevisionToAwait>>;

MaybeAwait WhatToAwait(const Runtime& runtime, const v1::StreamQueriesRequest& request) {
  return WithQuery(
      request,
      [&](const auto& query) {
        const v1::QueryOptions& options = query.options();
        return server::WhatToAwait(runtime, query.world(), options.world_uid(),
                                   options.at_revision());
      },
      MaybeAwait(std::nullopt));
}

}  // namespace

StreamQueriesCall* StreamQueriesCall::Start(grpc::CallbackServerContext* context,
                                            Runtime& runtime) {
  const std::shared_ptr<StreamQueriesCall> call(new StreamQueriesCall(context, runtime));
  call->self_ = call;
  call->counted_ = runtime.streams.TryTake();
  if (call->counted_) {
    call->Advance();
    runtime.AddDrainable(call);
  } else {
    call->is_over_ = true;
    call->Finish(ToGrpcStatus(Overloaded("too many streams are open", "TOO_MANY_STREAMS")));
  }
  return call.get();
}

StreamQueriesCall::StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime)
    : runtime_(runtime), deadline_(DeadlineOf(*context)) {}

void StreamQueriesCall::Advance() {
  const auto self = shared_from_this();  // what is moved on may end the call
  bool has_begun = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_over_) return;
    has_begun = MoveOn();
  }
  if (has_begun) Begin();
}

// True when a question has come to be answered.
bool StreamQueriesCall::MoveOn() {
  if (answer_ == Place::kDone && write_ == Place::kEmpty) {
    written_.Swap(&response_);
    answer_ = Place::kEmpty;
    write_ = Place::kUnderWay;
    StartWrite(&written_);
  }
  const bool goes_on = !client_is_gone_ && !runtime_.draining();
  const bool begins = goes_on && read_ == Place::kDone && answer_ == Place::kEmpty;
  if (begins) {
    request_.Swap(&next_);
    read_ = Place::kEmpty;
    answer_ = Place::kUnderWay;
  }
  if (is_ahead_ && (read_ == Place::kEmpty || answer_ == Place::kEmpty)) {
    runtime_.read_ahead.GiveBack();
    is_ahead_ = false;
  }
  if (goes_on) Read();
  FinishIfOver();
  return begins;
}

void StreamQueriesCall::Read() {
  if (read_ != Place::kEmpty || client_is_done_) return;
  if (answer_ != Place::kEmpty) {
    is_ahead_ = runtime_.read_ahead.TryTake();
    if (!is_ahead_) return;
  }
  read_ = Place::kUnderWay;
  StartRead(&next_);
}

void StreamQueriesCall::FinishIfOver() {
  if (answer_ != Place::kEmpty || write_ != Place::kEmpty) return;
  absl::Status status;
  if (client_is_gone_ || stop_.stop_requested()) {
    status = CallCancelled();
  } else if (runtime_.draining()) {
    status = Draining();
  } else if (!client_is_done_ || read_ != Place::kEmpty) {
    return;
  }
  is_over_ = true;
  Finish(ToGrpcStatus(status));
}

void StreamQueriesCall::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    read_ = ok ? Place::kDone : Place::kEmpty;
    client_is_done_ = !ok;
  }
  Advance();
}

void StreamQueriesCall::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    write_ = Place::kEmpty;
    client_is_gone_ = !ok;
    written_ = v1::StreamQueriesResponse();  // an idle stream keeps no answer: Clear would
  }
  Advance();
}

WorkQueue& StreamQueriesCall::Queue() {
  const bool is_batch = WithQuery(
      request_, [&](const auto& query) { return IsBatch(query, cost_s_); },
      cost_s_ > kMaxCostOfFew_s);
  return is_batch ? runtime_.batches : runtime_.query;
}

void StreamQueriesCall::Begin() {
  cost_s_ = CostOf(runtime_, request_);
  if (auto status = CheckCost(cost_s_, runtime_.application.limits); !status.ok()) {
    return Answered(status);
  }
  const MaybeAwait await = WhatToAwait(runtime_, request_);
  if (!await.ok()) return Answered(await.status());
  reached_.reset();
  if (!await->has_value()) return Enqueue();
  const std::shared_ptr<World>& world = (*await)->world;
  runtime_.waits.Await({world, (*await)->revision, deadline_, stop_.get_token()}, Queue(),
                       [self = shared_from_this(), world](absl::StatusOr<SnapshotPtr> snapshot) {
                         if (!snapshot.ok()) return self->Answered(snapshot.status());
                         self->reached_ = {world, *std::move(snapshot)};
                         self->Work();
                       });
}

void StreamQueriesCall::Enqueue() {
  if (Queue().TryPush([self = shared_from_this()] { self->Work(); })) return;
  Answered(Overloaded("the server has more work than it can take", "QUEUE_FULL"));
}

void StreamQueriesCall::Work() {
  // An idle stream keeps no world alive.
  const CallContext call{deadline_, stop_.get_token(), std::exchange(reached_, std::nullopt)};
  Answered(RunGuarded([this](const CallContext& c) { return AnswerRequest(c); }, call));
}

absl::Status StreamQueriesCall::AnswerRequest(const CallContext& call) {
  if (request_.has_overlay()) {
    WorkBudget budget(call.deadline, call.stop);
    auto status = memory_.overlay.Set(runtime_.application, request_.overlay(), &budget);
    const bool is_all = request_.query_case() == v1::StreamQueriesRequest::QUERY_NOT_SET;
    if (is_all || !status.ok()) return status;
  }
  switch (request_.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return Answer(runtime_, request_.check_collisions(), call, &memory_,
                    response_.mutable_check_collisions());
    case v1::StreamQueriesRequest::kGetDistances:
      return Answer(runtime_, request_.get_distances(), call, &memory_,
                    response_.mutable_get_distances());
    case v1::StreamQueriesRequest::kGetContacts:
      return Answer(runtime_, request_.get_contacts(), call, &memory_,
                    response_.mutable_get_contacts());
    case v1::StreamQueriesRequest::kCastRays:
      return Answer(runtime_, request_.cast_rays(), call, &memory_, response_.mutable_cast_rays());
    case v1::StreamQueriesRequest::kSamplePoints:
      return Answer(runtime_, request_.sample_points(), call, &memory_,
                    response_.mutable_sample_points());
    case v1::StreamQueriesRequest::kCheckMotions:
      return Answer(runtime_, request_.check_motions(), call, &memory_,
                    response_.mutable_check_motions());
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return InvalidField("query",
                      "is absent, must be one of check_collisions, get_distances, get_contacts, "
                      "cast_rays, sample_points, check_motions");
}

void StreamQueriesCall::Answered(const absl::Status& status) {
  response_.set_id(request_.id());
  if (!status.ok()) *response_.mutable_error() = ToQueryError(status);
  request_ = v1::StreamQueriesRequest();  // an idle stream keeps no question
  {
    const std::lock_guard lock(mutex_);
    answer_ = Place::kDone;
  }
  Advance();
}

void StreamQueriesCall::OnDone() {
  if (counted_) runtime_.streams.GiveBack();
  self_.reset();  // *this may be gone after it
}

}  // namespace cwm::server
