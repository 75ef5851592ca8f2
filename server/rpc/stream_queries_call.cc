#include "server/rpc/stream_queries_call.h"

#include "server/core/error.h"
#include "server/rpc/call.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

const v1::AtRevision& RuleOf(const v1::StreamQueriesRequest& request) {
  switch (request.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return request.check_collisions().options().at_revision();
    case v1::StreamQueriesRequest::kGetDistances:
      return request.get_distances().options().at_revision();
    case v1::StreamQueriesRequest::kGetContacts:
      return request.get_contacts().options().at_revision();
    case v1::StreamQueriesRequest::kCastRays:
      return request.cast_rays().options().at_revision();
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return v1::AtRevision::default_instance();
}

const std::string& WorldOf(const v1::StreamQueriesRequest& request) {
  switch (request.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return request.check_collisions().world();
    case v1::StreamQueriesRequest::kGetDistances:
      return request.get_distances().world();
    case v1::StreamQueriesRequest::kGetContacts:
      return request.get_contacts().world();
    default:
      return request.cast_rays().world();
  }
}

}  // namespace

StreamQueriesCall* StreamQueriesCall::Start(grpc::CallbackServerContext* context,
                                            Runtime& runtime) {
  const std::shared_ptr<StreamQueriesCall> call(new StreamQueriesCall(context, runtime));
  call->self_ = call;
  call->counted_ = runtime.streams.TryTake();
  if (call->counted_) {
    call->ReadNext();
    runtime.AddDrainable(call);
  } else {
    call->FinishOnce(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  }
  return call.get();
}

StreamQueriesCall::StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime)
    : runtime_(runtime), deadline_(DeadlineOf(*context)) {}

void StreamQueriesCall::ReadNext() {
  {
    const std::lock_guard lock(mutex_);
    reading_ = true;
  }
  StartRead(&request_);
  if (runtime_.draining()) Drain();
}

void StreamQueriesCall::Drain() {
  {
    const std::lock_guard lock(mutex_);
    if (!reading_) return;  // OnWriteDone looks again
  }
  FinishOnce(Draining());
}

void StreamQueriesCall::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    reading_ = false;
    if (finished_) return;
  }
  if (!ok) return FinishOnce(stop_.stop_requested() ? CallCancelled() : absl::OkStatus());
  const auto await = WhatToAwait(runtime_, WorldOf(request_), RuleOf(request_));
  if (!await) return Enqueue();
  runtime_.WhenReached(await->world, await->revision, deadline_, stop_.get_token(),
                       [this](const absl::Status& status) {
                         if (status.ok()) return Enqueue();
                         Reply(status);
                       });
}

void StreamQueriesCall::Enqueue() {
  const auto work = [this] {
    const CallContext call{deadline_, stop_.get_token()};
    Reply(RunGuarded([this](const CallContext& c) { return AnswerRequest(c); }, call));
  };
  if (runtime_.query.TryPush(work)) return;
  Reply(Overloaded("the server has more work than it can take", "QUEUE_FULL"));
}

absl::Status StreamQueriesCall::AnswerRequest(const CallContext& call) {
  switch (request_.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return Answer(runtime_, request_.check_collisions(), call, &held_,
                    response_.mutable_check_collisions());
    case v1::StreamQueriesRequest::kGetDistances:
      return Answer(runtime_, request_.get_distances(), call, &held_,
                    response_.mutable_get_distances());
    case v1::StreamQueriesRequest::kGetContacts:
      return Answer(runtime_, request_.get_contacts(), call, &held_,
                    response_.mutable_get_contacts());
    case v1::StreamQueriesRequest::kCastRays:
      return Answer(runtime_, request_.cast_rays(), call, &held_, response_.mutable_cast_rays());
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return InvalidField("query",
                      "is absent, must be one of check_collisions, get_distances, get_contacts, "
                      "cast_rays");
}

void StreamQueriesCall::Reply(const absl::Status& status) {
  response_.set_id(request_.id());
  if (!status.ok()) *response_.mutable_error() = ToQueryError(status);
  StartWrite(&response_);
}

void StreamQueriesCall::OnWriteDone(bool ok) {
  if (!ok) return FinishOnce(CallCancelled());
  response_.Clear();
  ReadNext();
}

void StreamQueriesCall::FinishOnce(const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    if (finished_) return;
    finished_ = true;
  }
  Finish(ToGrpcStatus(status));
}

void StreamQueriesCall::OnDone() {
  if (counted_) runtime_.streams.GiveBack();
  self_.reset();  // *this may be gone after it
}

}  // namespace cwm::server
