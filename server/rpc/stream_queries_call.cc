#include "server/rpc/stream_queries_call.h"

#include <utility>

#include "server/core/error.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
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
    call->ReadNext();
    runtime.AddDrainable(call);
  } else {
    call->End(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  }
  return call.get();
}

StreamQueriesCall::StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime)
    : runtime_(runtime), deadline_(DeadlineOf(*context)) {}

void StreamQueriesCall::ReadNext() {
  {
    const std::lock_guard lock(mutex_);
    turn_ = Turn::kClients;
    StartRead(&request_);
  }
  // Drain may have looked just before.
  if (runtime_.draining()) Drain();
}

bool StreamQueriesCall::TakeTurn() {
  const std::lock_guard lock(mutex_);
  if (turn_ != Turn::kClients) return false;
  turn_ = Turn::kOurs;
  return true;
}

void StreamQueriesCall::Drain() {
  // Whoever has the turn looks again when it reads on.
  if (TakeTurn()) End(Draining());
}

void StreamQueriesCall::OnReadDone(bool ok) {
  if (!TakeTurn()) return;  // drained: Finish was called
  if (!ok) return End(stop_.stop_requested() ? CallCancelled() : absl::OkStatus());
  const MaybeAwait await = WhatToAwait(runtime_, request_);
  if (!await.ok()) return Reply(await.status());
  reached_.reset();
  if (!await->has_value()) return Enqueue();
  const std::shared_ptr<World>& world = (*await)->world;
  runtime_.waits.Await({world, (*await)->revision, deadline_, stop_.get_token()}, runtime_.query,
                       [self = shared_from_this(), world](absl::StatusOr<SnapshotPtr> snapshot) {
                         if (!snapshot.ok()) return self->Reply(snapshot.status());
                         self->reached_ = {world, *std::move(snapshot)};
                         self->Work();
                       });
}

void StreamQueriesCall::Enqueue() {
  if (runtime_.query.TryPush([self = shared_from_this()] { self->Work(); })) return;
  Reply(Overloaded("the server has more work than it can take", "QUEUE_FULL"));
}

void StreamQueriesCall::Work() {
  // An idle stream keeps no world alive.
  const CallContext call{deadline_, stop_.get_token(), std::exchange(reached_, std::nullopt)};
  Reply(RunGuarded([this](const CallContext& c) { return AnswerRequest(c); }, call));
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
    case v1::StreamQueriesRequest::kSamplePoints:
      return Answer(runtime_, request_.sample_points(), call, &held_,
                    response_.mutable_sample_points());
    case v1::StreamQueriesRequest::kCheckMotions:
      return Answer(runtime_, request_.check_motions(), call, &held_,
                    response_.mutable_check_motions());
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return InvalidField("query",
                      "is absent, must be one of check_collisions, get_distances, get_contacts, "
                      "cast_rays, sample_points, check_motions");
}

void StreamQueriesCall::Reply(const absl::Status& status) {
  response_.set_id(request_.id());
  if (!status.ok()) *response_.mutable_error() = ToQueryError(status);
  request_ = v1::StreamQueriesRequest();  // an idle stream keeps no question: Clear would
  StartWrite(&response_);
}

void StreamQueriesCall::OnWriteDone(bool ok) {
  const auto self = shared_from_this();  // the read may end the call before ReadNext returns
  if (!ok) return End(CallCancelled());
  response_ = v1::StreamQueriesResponse();  // and no answer
  ReadNext();
}

// Keeps the turn for ever: nothing else happens to this call.
void StreamQueriesCall::End(const absl::Status& status) { Finish(ToGrpcStatus(status)); }

void StreamQueriesCall::OnDone() {
  if (counted_) runtime_.streams.GiveBack();
  self_.reset();  // *this may be gone after it
}

}  // namespace cwm::server
