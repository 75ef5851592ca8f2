// A call as the services see it: its deadline, its cancellation, and unary calls whose work runs on
// a queue.
#pragma once

#include <google/protobuf/arena.h>
#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/rpc/messages.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

struct WorldAtRevision {
  std::shared_ptr<World> world;
  SnapshotPtr snapshot;
};

struct CallContext {
  Clock::time_point deadline = Clock::time_point::max();  // max: no deadline
  std::stop_token stop;
  std::optional<WorldAtRevision> reached = {};  // the revision that the call awaited, if any
  ClientId client = {};
};

// The call's deadline on the steady clock.
Clock::time_point DeadlineOf(const grpc::CallbackServerContext& context);

// When the answer must be sent with what is complete by then: the smaller of the budget and 0.9 of
// the remaining deadline. Empty if there is neither.
std::optional<Clock::time_point> AnswerDeadline(std::optional<std::chrono::nanoseconds> time_budget,
                                                Clock::time_point deadline);

// A revision that the world has to reach before the work can begin.
struct RevisionToAwait {
  std::shared_ptr<World> world;
  collision::Revision revision;
};
using MaybeAwait = absl::StatusOr<std::optional<RevisionToAwait>>;

// measured: 16 MiB of the smallest messages take 0.3 s.
inline constexpr double kParsing_s_per_byte = 20e-9;
// measured: requests up to this size are parsed by the thread that read them, in at most about 1.3
// ms.
inline constexpr std::size_t kMaxParsedAtOnceBytes = 64 << 10;

using CallWork = std::function<absl::Status(const CallContext&)>;
// Ends a call with its status, once, from any thread.
using EndCall = std::function<void(const absl::Status&)>;

// Runs `work`; an exception that gets this far (out of memory, a foreign library) becomes a status.
absl::Status RunGuarded(const CallWork& work, const CallContext& call);

// SERVER_DRAINING for a call that was cancelled because the server stops; other statuses stay as
// they are.
absl::Status DrainingIfStopped(absl::Status status, const Runtime& runtime);

// The expected duration of work.
enum class WorkLength {
  kAny,
  kShort,  // less than waking another thread
  // Negligible, and it must not wait for anything: done at once by the thread that read the
  // request.
  kImmediate,
};

// How to work on a parsed request.
struct UnaryPlan {
  WorkQueue* queue = nullptr;
  MaybeAwait await = {std::nullopt};
  WorkLength length = WorkLength::kAny;
  double cost_s = 0;                   // estimated time on one core
  bool allows_partial_answer = false;  // can return what is complete when the time is over
};

// A unary call, from its bytes to its status. Deletes itself when gRPC is done with it. The
// request's memory is charged to its client before it is parsed. Large requests are parsed on a
// queue. Work that has not begun when the server drains is refused with SERVER_DRAINING.
class UnaryCall : public grpc::ServerUnaryReactor {
 protected:
  UnaryCall(grpc::CallbackServerContext* context, Runtime& runtime,
            const grpc::ByteBuffer* request);

  virtual absl::Status Parse(grpc::ByteBuffer& bytes, WorkBudget* budget) = 0;
  virtual UnaryPlan MakePlan() = 0;
  // Calls `end` when the response is complete, at once or later. If it throws, it does not call it.
  virtual void Work(const CallContext& call, EndCall end) = 0;
  // Frees request and response, which are not used afterwards.
  virtual grpc::Status Serialize() = 0;
  virtual std::int64_t ParsedBytes() const = 0;
  virtual std::int64_t ReplyBytes() const = 0;
  // True if the call is served while worlds are restored, too.
  virtual bool IsAlwaysServed() const = 0;
  // E.g. "/cwm.v1.WorldService/GetWorld".
  virtual std::string Method() const = 0;

 public:
  // `parses` is the queue for requests that are too large to be parsed at once.
  void Start(WorkQueue& parses);

 private:
  void ParseAndPlan();
  void Run();
  void Enqueue(const UnaryPlan& plan);
  void End(const absl::Status& status);
  // Logs refusals and slow calls. *this may be gone afterwards.
  void FinishAndLog(const grpc::Status& status, std::int64_t reply_bytes);
  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { delete this; }

  grpc::CallbackServerContext* const context_;
  Runtime& runtime_;
  grpc::ByteBuffer& bytes_;  // the request's bytes until it is parsed
  const std::size_t request_bytes_;
  const Clock::time_point begin_ = Clock::now();
  std::stop_source stop_;
  const OpenCalls::Token open_{runtime_.open_calls, stop_};
  CallContext call_;
  MemoryCharge charge_;
  StallTimers::Guard reading_;  // while the client reads the reply
};

template <class Request, class Response>
struct UnaryMethod {
  std::function<UnaryPlan(const Request&)> plan;
  std::function<absl::Status(const Request&, const CallContext&, Response*)> work = {};
  // In place of `work`, for an answer that waits for the disk: see UnaryCall::Work. The response
  // lives until `end` is called.
  std::function<void(const Request&, const CallContext&, Response*, EndCall end)> start = {};
  bool is_always_served = false;  // while worlds are restored, too
};

template <class Request, class Response>
class UnaryCallOf final : public UnaryCall {
 public:
  UnaryCallOf(grpc::CallbackServerContext* context, Runtime& runtime,
              const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
              UnaryMethod<Request, Response> method)
      : UnaryCall(context, runtime, request),
        method_(std::move(method)),
        request_(google::protobuf::Arena::CreateMessage<Request>(&arena_)),
        response_(google::protobuf::Arena::CreateMessage<Response>(&arena_)),
        reply_(response) {}

 private:
  absl::Status Parse(grpc::ByteBuffer& bytes, WorkBudget* budget) override {
    return ParseRequest(bytes, request_, budget);
  }
  UnaryPlan MakePlan() override { return method_.plan(*request_); }
  void Work(const CallContext& call, EndCall end) override {
    if (method_.start) return method_.start(*request_, call, response_, std::move(end));
    const absl::Status worked = method_.work(*request_, call, response_);
    end(worked);
  }
  grpc::Status Serialize() override {
    const grpc::Status status = SerializeResponse(*response_, reply_);
    arena_.Reset();
    return status;
  }
  std::int64_t ParsedBytes() const override {
    return static_cast<std::int64_t>(arena_.SpaceAllocated());
  }
  std::int64_t ReplyBytes() const override { return static_cast<std::int64_t>(reply_->Length()); }
  bool IsAlwaysServed() const override { return method_.is_always_served; }
  std::string Method() const override { return MethodWithRequest(*Request::descriptor()); }

  const UnaryMethod<Request, Response> method_;
  // Requests and replies in rows contain thousands of small messages, which the arena frees at
  // once.
  google::protobuf::Arena arena_;
  Request* const request_;
  Response* const response_;
  grpc::ByteBuffer* const reply_;
};

// Starts the call of a raw method.
template <class Request, class Response>
grpc::ServerUnaryReactor* StartUnary(grpc::CallbackServerContext* context, Runtime& runtime,
                                     const grpc::ByteBuffer* request, grpc::ByteBuffer* response,
                                     WorkQueue& parses, UnaryMethod<Request, Response> method) {
  auto* const call =
      new UnaryCallOf<Request, Response>(context, runtime, request, response, std::move(method));
  call->Start(parses);
  return call;
}

}  // namespace cwm::server
