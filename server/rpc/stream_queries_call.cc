#include "server/rpc/stream_queries_call.h"

#include <utility>

#include "server/core/error.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/messages.h"
#include "server/rpc/query_queue.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

constexpr char kMethod[] = "/cwm.v1.QueryService/StreamQueries";

// Calls `use` with the query's message; returns `otherwise` if there is none.
template <class Use, class Result>
Result WithQuery(const v1::StreamQueriesRequest& request, const Use& use, Result otherwise) {
  switch (request.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return use(request.check_collisions());
    case v1::StreamQueriesRequest::kGetDistances:
      return use(request.get_distances());
    case v1::StreamQueriesRequest::kGetContacts:
      return use(request.get_contacts());
    case v1::StreamQueriesRequest::kGetWorldContacts:
      return use(request.get_world_contacts());
    case v1::StreamQueriesRequest::kCastRays:
      return use(request.cast_rays());
    case v1::StreamQueriesRequest::kSamplePoints:
      return use(request.sample_points());
    case v1::StreamQueriesRequest::kCheckMotions:
      return use(request.check_motions());
    case v1::StreamQueriesRequest::kSolvePoses:
      return use(request.solve_poses());
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

MaybeAwait FindRevisionToAwait(const Runtime& runtime, const v1::StreamQueriesRequest& request) {
  return WithQuery(
      request,
      [&](const auto& query) {
        const v1::QueryOptions& options = query.options();
        return server::FindRevisionToAwait(runtime, query.world(), options.world_uid(),
                                           options.at_revision());
      },
      MaybeAwait(std::nullopt));
}

}  // namespace

StreamQueriesCall* StreamQueriesCall::Start(grpc::CallbackServerContext* context,
                                            Runtime& runtime) {
  const std::shared_ptr<StreamQueriesCall> call(new StreamQueriesCall(context, runtime));
  call->self_ = call;
  if (absl::Status serving = runtime.application.gate.Check(); !serving.ok()) {
    call->End(serving);
    return call.get();
  }
  call->quota_share_ = QuotaShare::TryTake(runtime.streams, call->client_);
  if (call->quota_share_) {
    call->Advance();
    runtime.AddDrainable(call);
  } else {
    call->End(Overloaded("too many streams are open", "TOO_MANY_STREAMS"));
  }
  return call.get();
}

StreamQueriesCall::StreamQueriesCall(grpc::CallbackServerContext* context, Runtime& runtime)
    : runtime_(runtime),
      deadline_(DeadlineOf(*context)),
      context_(context),
      client_(runtime.ClientOf(*context)),
      charge_(MemoryCharge::Empty(runtime.application.memory, MemoryBudget::Client(client_))) {}

void StreamQueriesCall::Advance() {
  const auto self = shared_from_this();  // advancing may end the call
  bool has_begun = false;
  {
    const std::lock_guard lock(mutex_);
    if (is_over_) return;
    has_begun = AdvanceLocked();
  }
  if (!has_begun) return;
  AnswerOnException([this] { Begin(); });
}

// Advances all places. True if a query has come to be answered.
bool StreamQueriesCall::AdvanceLocked() {
  if (answer_ == SlotState::kDone && write_ == SlotState::kEmpty) {
    written_.Swap(&answered_);
    answer_ = SlotState::kEmpty;
    write_ = SlotState::kInProgress;
    reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                  [this] { context_->TryCancel(); });
    StartWrite(&written_);
  }
  const bool goes_on = !client_is_gone_ && stream_error_.ok() && !runtime_.draining();
  const bool begins = goes_on && read_ == SlotState::kDone && answer_ == SlotState::kEmpty;
  if (begins) {
    request_bytes_.Swap(&next_);
    read_ = SlotState::kEmpty;
    answer_ = SlotState::kInProgress;
  }
  if (read_ == SlotState::kEmpty || answer_ == SlotState::kEmpty) ahead_.reset();
  if (goes_on) Read();
  FinishIfOver();
  return begins;
}

void StreamQueriesCall::Read() {
  if (read_ != SlotState::kEmpty || client_is_done_) return;
  if (answer_ != SlotState::kEmpty) {
    ahead_ = QuotaShare::TryTake(runtime_.read_ahead, client_);
    if (!ahead_) return;
  }
  read_ = SlotState::kInProgress;
  StartRead(&next_);
}

void StreamQueriesCall::FinishIfOver() {
  if (answer_ != SlotState::kEmpty || write_ != SlotState::kEmpty) return;
  absl::Status status;
  if (runtime_.draining()) {
    status = Draining();
  } else if (client_is_gone_ || stop_.stop_requested()) {
    status = CallCancelled();
  } else if (!stream_error_.ok()) {
    status = stream_error_;
  } else if (!client_is_done_ || read_ != SlotState::kEmpty) {
    return;
  }
  End(status);
}

void StreamQueriesCall::End(const absl::Status& status) {
  is_over_ = true;
  if (!status.ok()) {
    runtime_.log.Refused(kMethod, status.code(), DetailsOf(status).reason, client_);
  }
  Finish(ToGrpcStatus(status));
}

void StreamQueriesCall::OnReadDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    if (!ok) client_is_done_ = true;
    read_ = ok ? SlotState::kDone : SlotState::kEmpty;
  }
  Advance();
}

void StreamQueriesCall::OnWriteDone(bool ok) {
  reading_ = {};
  open_.NoteProgress();
  {
    const std::lock_guard lock(mutex_);
    write_ = SlotState::kEmpty;
    client_is_gone_ = !ok;
    written_.Clear();
  }
  Advance();
}

WorkQueue& StreamQueriesCall::Queue() {
  const bool is_batch = WithQuery(
      request_, [&](const auto& query) { return IsBatch(query, cost_s_); },
      cost_s_ > kMaxSmallQueryCost_s);
  return is_batch ? runtime_.batches : runtime_.query;
}

void StreamQueriesCall::Begin() {
  begin_time_ = Clock::now();
  const std::size_t size = request_bytes_.Length();
  // While it is parsed, the request is in memory twice.
  const absl::Status charged = charge_.Resize(2 * static_cast<std::int64_t>(size));
  if (!charged.ok()) {
    request_bytes_.Clear();
    return OnAnswered(charged);
  }
  if (size <= kMaxParsedAtOnceBytes) return ParseAndPlan();
  runtime_.batches.Push({.run =
                             [self = shared_from_this()](const absl::Status& admitted) {
                               if (!admitted.ok()) return self->OnAnswered(admitted);
                               self->AnswerOnException([&self] { self->ParseAndPlan(); });
                             },
                         .client = client_,
                         .cost_s = kParsing_s_per_byte * static_cast<double>(size),
                         .deadline = deadline_});
}

void StreamQueriesCall::ParseAndPlan() {
  WorkBudget budget(deadline_, stop_.get_token());
  const absl::Status parsed = ParseRequest(request_bytes_, &request_, &budget);
  if (!parsed.ok()) return FailStream(parsed);
  charge_.ForceResize(static_cast<std::int64_t>(request_.SpaceUsedLong()));
  Plan();
}

void StreamQueriesCall::AnswerOnException(const std::function<void()>& work) {
  const absl::Status done = RunGuarded(
      [&work](const CallContext&) {
        work();
        return absl::OkStatus();
      },
      {});
  if (!done.ok()) OnAnswered(done);
}

// Ends the stream: the message cannot be parsed, so later ones cannot be trusted either.
void StreamQueriesCall::FailStream(const absl::Status& status) {
  {
    const std::lock_guard lock(mutex_);
    stream_error_ = status;  // a message that is being read now is not answered either
    answer_ = SlotState::kEmpty;
  }
  Advance();
}

void StreamQueriesCall::Plan() {
  cost_s_ = CostOf(runtime_, request_);
  if (auto status = CheckCost(cost_s_, runtime_.application.limits); !status.ok()) {
    return OnAnswered(status);
  }
  const MaybeAwait await = FindRevisionToAwait(runtime_, request_);
  if (!await.ok()) return OnAnswered(await.status());
  reached_.reset();
  if (!await->has_value()) return Enqueue();
  const std::shared_ptr<World>& world = (*await)->world;
  runtime_.waits.Await({.world = world,
                        .revision = (*await)->revision,
                        .deadline = deadline_,
                        .stop = stop_.get_token(),
                        .client = client_,
                        .cost_s = cost_s_,
                        .allows_partial_answer = true},
                       Queue(),
                       [self = shared_from_this(), world](absl::StatusOr<SnapshotPtr> snapshot) {
                         if (!snapshot.ok()) return self->OnAnswered(snapshot.status());
                         self->reached_ = {world, *std::move(snapshot)};
                         self->Work();
                       });
}

void StreamQueriesCall::Enqueue() {
  Queue().Push({.run =
                    [self = shared_from_this()](const absl::Status& admitted) {
                      if (!admitted.ok()) return self->OnAnswered(admitted);
                      self->Work();
                    },
                .client = client_,
                .cost_s = cost_s_,
                .deadline = deadline_,
                .allows_partial_answer = true});
}

void StreamQueriesCall::Work() {
  // Releases the snapshot, so that an idle stream keeps no world alive.
  const CallContext call{.deadline = deadline_,
                         .stop = stop_.get_token(),
                         .reached = std::exchange(reached_, std::nullopt),
                         .client = client_};
  if (runtime_.draining()) return OnAnswered(Draining());
  const auto status = RunGuarded([this](const CallContext& c) { return AnswerRequest(c); }, call);
  OnAnswered(DrainingIfStopped(status, runtime_));
}

absl::Status StreamQueriesCall::AnswerRequest(const CallContext& call) {
  if (request_.has_overlay()) {
    WorkBudget budget(call.deadline, call.stop);
    auto status = memory_.overlay.Set(runtime_.application, request_.overlay(), client_, &budget);
    const bool is_all = request_.query_case() == v1::StreamQueriesRequest::QUERY_NOT_SET;
    if (is_all || !status.ok()) return status;
  }
  switch (request_.query_case()) {
    case v1::StreamQueriesRequest::kCheckCollisions:
      return AnswerQuery(runtime_, request_.check_collisions(), call, &memory_,
                         response_.mutable_check_collisions());
    case v1::StreamQueriesRequest::kGetDistances:
      return AnswerQuery(runtime_, request_.get_distances(), call, &memory_,
                         response_.mutable_get_distances());
    case v1::StreamQueriesRequest::kGetContacts:
      return AnswerQuery(runtime_, request_.get_contacts(), call, &memory_,
                         response_.mutable_get_contacts());
    case v1::StreamQueriesRequest::kGetWorldContacts:
      return AnswerQuery(runtime_, request_.get_world_contacts(), call, &memory_,
                         response_.mutable_get_world_contacts());
    case v1::StreamQueriesRequest::kCastRays:
      return AnswerQuery(runtime_, request_.cast_rays(), call, &memory_,
                         response_.mutable_cast_rays());
    case v1::StreamQueriesRequest::kSamplePoints:
      return AnswerQuery(runtime_, request_.sample_points(), call, &memory_,
                         response_.mutable_sample_points());
    case v1::StreamQueriesRequest::kCheckMotions:
      return AnswerQuery(runtime_, request_.check_motions(), call, &memory_,
                         response_.mutable_check_motions());
    case v1::StreamQueriesRequest::kSolvePoses:
      return AnswerQuery(runtime_, request_.solve_poses(), call, &memory_,
                         response_.mutable_solve_poses());
    case v1::StreamQueriesRequest::QUERY_NOT_SET:
      break;
  }
  return InvalidField("query",
                      "is absent, must be one of check_collisions, get_distances, get_contacts, "
                      "cast_rays, sample_points, check_motions, solve_poses, get_world_contacts");
}

void StreamQueriesCall::OnAnswered(const absl::Status& status) {
  response_.set_id(request_.id());
  if (!status.ok()) {
    *response_.mutable_error() = ToQueryError(status);
    runtime_.log.Refused(kMethod, status.code(), response_.error().reason(), client_);
  }
  const Clock::duration took = Clock::now() - begin_time_;
  if (took > kSlowCall) {
    runtime_.log.Slow(kMethod, status.code(), took, request_.ByteSizeLong(),
                      response_.ByteSizeLong());
  }
  // Clear would keep the memory of query and answer in an idle stream.
  request_ = v1::StreamQueriesRequest();
  const absl::Status serialized = RunGuarded(
      [this](const CallContext&) {
        const auto begin = Clock::now();
        SerializeResponse(response_, &answered_);
        runtime_.reply_slowdown.NoteSerialized(static_cast<std::int64_t>(answered_.Length()),
                                               Clock::now() - begin);
        return absl::OkStatus();
      },
      {});
  const std::int64_t id = response_.id();
  response_ = v1::StreamQueriesResponse();
  charge_.ForceResize(static_cast<std::int64_t>(answered_.Length()));
  if (!serialized.ok()) {
    response_.set_id(id);
    *response_.mutable_error() = ToQueryError(serialized);
    SerializeResponse(response_, &answered_);
  }
  {
    const std::lock_guard lock(mutex_);
    answer_ = SlotState::kDone;
  }
  Advance();
}

void StreamQueriesCall::OnDone() {
  self_.reset();  // *this may be gone afterwards
}

}  // namespace cwm::server
