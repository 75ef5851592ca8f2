#include "server/rpc/call.h"

#include <spdlog/spdlog.h>

#include <exception>
#include <new>
#include <utility>

#include "server/core/error.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

// The last tenth is for what nothing counts: a thread that wakes late, the way to the client.
constexpr double kShareOfDeadline = 0.9;

// Deletes itself when gRPC is done with it. The queue's task is the only one that finishes it.
class UnaryCall final : public grpc::ServerUnaryReactor {
 public:
  UnaryCall(grpc::CallbackServerContext* context, Runtime& runtime, CallWork work)
      : runtime_(runtime), call_{DeadlineOf(*context), stop_.get_token()}, work_(std::move(work)) {}

  void Enqueue(WorkQueue& queue, WorkLength length) {
    // gRPC keeps *this until the method that started the call has returned it.
    if (length == WorkLength::kShort && queue.TryRunHere([this] { Run(); })) return;
    if (queue.TryPush([this] { Run(); })) return;
    Refuse(Overloaded("the server has more work than it can take", "QUEUE_FULL"));
  }

  void EnqueueWhenReached(const RevisionToAwait& await, Runtime& runtime, WorkQueue& queue) {
    runtime.waits.Await({await.world, await.revision, call_.deadline, call_.stop}, queue,
                        [this, world = await.world](absl::StatusOr<SnapshotPtr> snapshot) {
                          if (!snapshot.ok()) return Refuse(snapshot.status());
                          call_.reached = {world, *std::move(snapshot)};
                          Run();
                        });
  }

  void Refuse(const absl::Status& status) { Finish(ToGrpcStatus(status)); }

 private:
  void Run() {
    absl::Status status;
    if (runtime_.draining()) {
      status = Draining();
    } else {
      status = call_.stop.stop_requested() ? CallCancelled() : RunGuarded(work_, call_);
    }
    Finish(ToGrpcStatus(WhyItEnded(std::move(status), runtime_)));  // *this may be gone after it
  }

  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  Runtime& runtime_;
  std::stop_source stop_;
  const OpenCalls::Token open_{runtime_.open_calls, stop_};
  CallContext call_;
  const CallWork work_;
};

}  // namespace

Clock::time_point DeadlineOf(const grpc::CallbackServerContext& context) {
  const auto deadline = context.deadline();
  const auto now = std::chrono::system_clock::now();
  // No deadline is the end of time, which the steady clock could not hold.
  constexpr auto kFar = std::chrono::hours(24 * 365);
  if (deadline > now + kFar) return Clock::time_point::max();
  return Clock::now() + std::chrono::duration_cast<Clock::duration>(deadline - now);
}

std::optional<Clock::time_point> GiveUpAt(std::optional<std::chrono::nanoseconds> time_budget,
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

absl::Status WhyItEnded(absl::Status status, const Runtime& runtime) {
  if (!absl::IsCancelled(status) || !runtime.open_calls.stop_requested()) return status;
  return Draining();
}

grpc::ServerUnaryReactor* StartUnary(grpc::CallbackServerContext* context, Runtime& runtime,
                                     WorkQueue& queue, CallWork work,
                                     absl::StatusOr<std::optional<RevisionToAwait>> await,
                                     WorkLength length) {
  auto* const call = new UnaryCall(context, runtime, std::move(work));
  if (runtime.draining()) {
    call->Refuse(Draining());
  } else if (!await.ok()) {
    call->Refuse(await.status());
  } else if (await->has_value()) {
    call->EnqueueWhenReached(**await, runtime, queue);
  } else {
    call->Enqueue(queue, length);
  }
  return call;
}

}  // namespace cwm::server
