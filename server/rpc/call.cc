#include "server/rpc/call.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <new>

#include "server/core/error.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// chosen: the last tenth is for delays that are not measured: a thread that wakes late, the way to
// the client.
constexpr double kShareOfDeadline = 0.9;

// chosen: smaller requests are not charged: a thousand of them take four mebibytes.
constexpr std::size_t kMinChargedBytes = 4 << 10;
// chosen: a smaller reply fits into the buffers of a socket and leaves at once, whether it is read
// or not.
constexpr std::int64_t kMinGuardedReplyBytes = 64 << 10;

}  // namespace

Clock::time_point DeadlineOf(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  const auto now = std::chrono::system_clock::now();
  // A missing deadline is the end of time, which the steady clock cannot represent.
  constexpr auto kFar = std::chrono::hours(24 * 365);
  if (deadline > now + kFar) return Clock::time_point::max();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(deadline - now);
}

std::optional<Clock::time_point> AnswerDeadline(std::optional<std::chrono::nanoseconds> time_budget,
                                                Clock::time_point deadline) {
  const auto now = Clock::now();
  std::optional<Clock::time_point> give_up_at;
  if (time_budget) give_up_at = now + *time_budget;
  if (deadline != Clock::time_point::max()) {
    const auto share =
        std::chrono::duration_cast<Clock::duration>((deadline - now) * kShareOfDeadline);
    give_up_at = give_up_at ? std::min(*give_up_at, now + share) : now + share;
  }
  return give_up_at;
}

absl::Status RunGuarded(const CallWork& work, const CallContext& call) {
  try {
    return work(call);
  } catch (const std::bad_alloc&) {
    return Overloaded("the server has not enough memory for this call", "OUT_OF_MEMORY");
  } catch (const std::exception& error) {
    spdlog::error("a call ended in an exception: {}", error.what());
    return MakeError(absl::StatusCode::kInternal, std::string("internal error: ") + error.what(),
                     {.reason = "INTERNAL", .fields = {}, .metadata = {}, .retry_after_s = {}});
  }
}

absl::Status DrainingIfStopped(absl::Status status, const Runtime& runtime) {
  if (!absl::IsCancelled(status) || !runtime.open_calls.stop_requested()) return status;
  return Draining();
}

UnaryCall::UnaryCall(grpc::CallbackServerContext* context, Runtime& runtime,
                     const grpc::ByteBuffer* request)
    : context_(context),
      runtime_(runtime),
      // gRPC lends its own buffer until the call is done, so the parsed bytes need not be kept
      // twice.
      bytes_(*const_cast<grpc::ByteBuffer*>(request)),
      request_bytes_(request->Length()),
      call_{.deadline = DeadlineOf(*context),
            .stop = stop_.get_token(),
            .client = runtime.ClientOf(*context)} {}

void UnaryCall::Start(WorkQueue& parses) {
  if (runtime_.draining()) return End(Draining());
  if (!IsAlwaysServed()) {
    const absl::Status serving = runtime_.application.gate.Check();
    if (!serving.ok()) return End(serving);
  }
  const std::size_t size = bytes_.Length();
  if (size >= kMinChargedBytes) {
    charge_ = MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(call_.client));
    // While it is parsed, the request is in memory twice.
    const absl::Status charged = charge_.Resize(2 * static_cast<std::int64_t>(size));
    if (!charged.ok()) return End(charged);
  }
  if (size <= kMaxParsedAtOnceBytes) return ParseAndPlan();
  parses.Push({.run =
                   [this](const absl::Status& admitted) {
                     if (!admitted.ok()) return End(admitted);
                     ParseAndPlan();
                   },
               .client = call_.client,
               .cost_s = kParsing_s_per_byte * static_cast<double>(size),
               .deadline = call_.deadline});
}

void UnaryCall::ParseAndPlan() {
  const auto size = static_cast<std::int64_t>(bytes_.Length());
  UnaryPlan plan;
  const CallWork parse = [&](const CallContext&) {
    WorkBudget budget(call_.deadline, call_.stop);
    if (absl::Status parsed = Parse(bytes_, &budget); !parsed.ok()) return parsed;
    const std::int64_t held = ParsedBytes() + size;  // text and bytes are stored outside the arena
    if (absl::Status charged = charge_.Resize(held); !charged.ok()) return charged;
    plan = MakePlan();
    return plan.await.status();
  };
  const absl::Status parsed = RunGuarded(parse, call_);
  if (!parsed.ok()) return End(parsed);
  // gRPC keeps *this alive until the method that started the call has returned it.
  if (plan.length == WorkLength::kImmediate) return Run();
  if (plan.await->has_value()) {
    const std::shared_ptr<World>& world = (*plan.await)->world;
    return runtime_.waits.Await({.world = world,
                                 .revision = (*plan.await)->revision,
                                 .deadline = call_.deadline,
                                 .stop = call_.stop,
                                 .client = call_.client,
                                 .cost_s = plan.cost_s,
                                 .allows_partial_answer = plan.allows_partial_answer},
                                *plan.queue, [this, world](absl::StatusOr<SnapshotPtr> snapshot) {
                                  if (!snapshot.ok()) return End(snapshot.status());
                                  call_.reached = {world, *std::move(snapshot)};
                                  Run();
                                });
  }
  if (plan.length == WorkLength::kShort && plan.queue->TryRunInline([this] { Run(); })) return;
  Enqueue(plan);
}

void UnaryCall::Enqueue(const UnaryPlan& plan) {
  plan.queue->Push({.run =
                        [this](const absl::Status& admitted) {
                          if (!admitted.ok()) return End(admitted);
                          Run();
                        },
                    .client = call_.client,
                    .cost_s = plan.cost_s,
                    .deadline = call_.deadline,
                    .allows_partial_answer = plan.allows_partial_answer});
}

void UnaryCall::Run() {
  if (runtime_.draining()) return End(Draining());
  if (call_.stop.stop_requested()) return End(CallCancelled());
  // *this may be gone when Work returns, but not if it throws.
  const absl::Status started = RunGuarded(
      [this](const CallContext& call) {
        Work(call, [this](const absl::Status& status) { End(status); });
        return absl::OkStatus();
      },
      call_);
  if (!started.ok()) End(started);
}

// The only place that finishes the call; *this may be gone afterwards.
void UnaryCall::End(const absl::Status& status) {
  if (!status.ok()) return FinishAndLog(ToGrpcStatus(DrainingIfStopped(status, runtime_)), 0);
  grpc::Status serialized;
  std::int64_t size = 0;
  const CallWork serialize = [&](const CallContext&) {
    const auto begin = Clock::now();
    serialized = Serialize();
    size = ReplyBytes();
    runtime_.reply_slowdown.NoteSerialized(size, Clock::now() - begin);
    if (size < kMinGuardedReplyBytes) return absl::OkStatus();
    // A large reply is sent only as fast as the client reads.
    if (charge_.bytes() == 0) {
      charge_ =
          MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(call_.client));
    }
    if (absl::Status charged = charge_.Resize(size); !charged.ok()) return charged;
    reading_ = StallTimers::Guard(runtime_.stalls, runtime_.application.limits.max_stall,
                                  [context = context_] { context->TryCancel(); });
    return absl::OkStatus();
  };
  const absl::Status ended = RunGuarded(serialize, call_);
  FinishAndLog(ended.ok() ? serialized : ToGrpcStatus(ended), size);
}

void UnaryCall::FinishAndLog(const grpc::Status& status, std::int64_t reply_bytes) {
  const auto code = static_cast<absl::StatusCode>(status.error_code());
  const auto took = Clock::now() - begin_;
  if (!status.ok()) runtime_.log.Refused(Method(), code, ReasonOf(status), call_.client);
  if (took > kSlowCall) {
    runtime_.log.Slow(Method(), code, took, request_bytes_, static_cast<std::size_t>(reply_bytes));
  }
  Finish(status);
}

}  // namespace cwm::server
