// Calls that send a header, then bytes in chunks: clouds, robots, meshes. gRPC's threads read them
// one message at a time; when the last has come, a task of a queue does the work.
#pragma once

#include <grpcpp/grpcpp.h>

#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <utility>

#include "server/core/error.h"
#include "server/rpc/call.h"
#include "server/rpc/messages.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {

// Owns itself until gRPC is done with it. Ends the call of a client that sends nothing for
// limits.max_stall, and uploads in progress when the server drains.
template <class Request, class Response>
class UploadCall : public grpc::ServerReadReactor<grpc::ByteBuffer>,
                   public Drainable,
                   public std::enable_shared_from_this<UploadCall<Request, Response>> {
 public:
  using Reactor = grpc::ServerReadReactor<grpc::ByteBuffer>;

  UploadCall(grpc::CallbackServerContext* context, Runtime& runtime, grpc::ByteBuffer* response)
      : runtime_(runtime),
        call_{.deadline = DeadlineOf(*context),
              .stop = stop_.get_token(),
              .client = runtime.ClientOf(*context)},
        reply_(response) {}

  // `call` must be new.
  static Reactor* Start(std::shared_ptr<UploadCall> call) {
    call->self_ = call;
    call->Begin();
    return call.get();
  }

  void Drain() override {
    if (is_reading_) End(Draining());
  }

 protected:
  // An empty charge on the client's account.
  MemoryCharge EmptyCharge() const {
    return MemoryCharge::Empty(runtime_.application.memory, MemoryBudget::Client(call_.client));
  }

  // Processes a message on gRPC's threads, so it may take milliseconds at most. All of these
  // functions may throw std::bad_alloc.
  virtual absl::Status Take(const Request& message) = 0;
  // Called when the client sends no more. OK if the upload is complete.
  virtual absl::Status CheckEnd() const = 0;
  // Called on the queue, once the upload is complete.
  virtual absl::Status Work() = 0;
  virtual WorkQueue& Queue() = 0;
  virtual double Cost_s() const = 0;
  // Called after a message was taken: a look-up to do on the queue before the next message is read,
  // or nullptr. It returns true if the call is done.
  virtual std::function<absl::StatusOr<bool>()> LookUp() { return nullptr; }

  // Ends the call for this reason, from any thread, unless it is over.
  void End(absl::Status status) {
    status = DrainingIfStopped(std::move(status), runtime_);
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(is_over_, true)) return;
    }
    is_reading_ = false;
    grpc::Status serialized;
    if (status.ok()) {
      status = RunGuarded(
          [&](const CallContext&) {
            serialized = SerializeResponse(response_, reply_);
            return absl::OkStatus();
          },
          call_);
    }
    this->Finish(status.ok() ? serialized : ToGrpcStatus(status));
  }

  Runtime& runtime_;
  std::stop_source stop_;
  const OpenCalls::Token open_{runtime_.open_calls, stop_};
  const CallContext call_;  // its stop is that of stop_
  Response response_;

 private:
  void Begin() {
    if (absl::Status serving = runtime_.CheckServing(); !serving.ok()) return End(serving);
    quota_share_ = QuotaShare::TryTake(runtime_.uploads, call_.client);
    if (!quota_share_) return End(Overloaded("too many uploads are under way", "TOO_MANY_UPLOADS"));
    sending_ = StallTimers::Guard(
        runtime_.stalls, runtime_.application.limits.max_stall, [weak = this->weak_from_this()] {
          if (const auto call = weak.lock(); call != nullptr && call->is_reading_) {
            call->End(call->Stalled());
          }
        });
    runtime_.AddDrainable(this->weak_from_this());
    ReadNext();
  }

  void ReadNext() {
    {
      const std::lock_guard lock(mutex_);  // gRPC does not react within StartRead
      if (is_over_) return;
      if (!runtime_.draining()) {
        is_reading_ = true;
        return this->StartRead(&bytes_);
      }
    }
    End(Draining());
  }

  void OnReadDone(bool ok) override {
    const auto self = this->shared_from_this();
    if (IsOver()) return;  // ended by a drain or a stall, after which its read fails
    sending_.Restart();
    if (!ok) return FinishUpload();
    if (bytes_.Length() <= MaxBytesTakenAtOnce()) return TakeMessage();
    // A header with many files or long texts is parsed on the queue.
    const auto size = static_cast<std::int64_t>(bytes_.Length());
    if (absl::Status charged = header_charge_.Resize(2 * size); !charged.ok()) return End(charged);
    Enqueue([this] { TakeMessage(); }, kParsing_s_per_byte * static_cast<double>(size));
  }

  std::size_t MaxBytesTakenAtOnce() const {
    constexpr std::size_t kMaxBytesBesideChunk = 4 << 10;
    const std::int64_t chunk = runtime_.application.limits.max_chunk_bytes;
    return static_cast<std::size_t>(chunk) + kMaxBytesBesideChunk;
  }

  void FinishUpload() {
    const CallWork check = [this](const CallContext&) {
      return call_.stop.stop_requested() ? CallCancelled() : CheckEnd();
    };
    if (const absl::Status checked = RunGuarded(check, call_); !checked.ok()) return End(checked);
    Enqueue([this] { End(RunGuarded(Guarded(), call_)); }, Cost_s());
  }

  void TakeMessage() {
    const CallWork take = [this](const CallContext&) {
      Request message;
      WorkBudget budget(Clock::time_point::max(), call_.stop);
      if (absl::Status parsed = ParseRequest(bytes_, &message, &budget); !parsed.ok()) {
        return parsed;
      }
      if (header_charge_.bytes() > 0) {  // a charged header is kept until the end
        const auto held = static_cast<std::int64_t>(message.SpaceUsedLong());
        if (absl::Status charged = header_charge_.Resize(held); !charged.ok()) return charged;
      }
      return Take(message);
    };
    if (const absl::Status taken = RunGuarded(take, call_); !taken.ok()) return End(taken);
    if (auto look_up = LookUp()) {
      return Enqueue([this, look_up = std::move(look_up)] { EndOrReadNext(look_up); }, 0);
    }
    ReadNext();
  }

  CallWork Guarded() {
    return [this](const CallContext& call) {
      if (runtime_.draining()) return Draining();
      return call.stop.stop_requested() ? CallCancelled() : Work();
    };
  }

  void EndOrReadNext(const std::function<absl::StatusOr<bool>()>& look_up) {
    bool is_done = false;
    const CallWork guarded = [&](const CallContext&) {
      const absl::StatusOr<bool> done = look_up();
      if (done.ok()) is_done = *done;
      return done.status();
    };
    const absl::Status looked_up = RunGuarded(guarded, call_);
    if (is_done || !looked_up.ok()) return End(looked_up);
    ReadNext();
  }

  void Enqueue(std::function<void()> work, double cost_s) {
    is_reading_ = false;
    Queue().Push({.run =
                      [self = this->shared_from_this(),
                       work = std::move(work)](const absl::Status& admitted) {
                        if (!admitted.ok()) return self->End(admitted);
                        if (!self->IsOver()) work();
                      },
                  .client = call_.client,
                  .cost_s = cost_s,
                  .deadline = call_.deadline});
  }

  absl::Status Stalled() const {
    const double limit_s =
        std::chrono::duration<double>(runtime_.application.limits.max_stall).count();
    return MakeError(absl::StatusCode::kDeadlineExceeded,
                     absl::StrCat("upload: nothing came for ", limit_s, " s"),
                     {.reason = "UPLOAD_STALLED"});
  }

  bool IsOver() {
    const std::lock_guard lock(mutex_);
    return is_over_;
  }

  void OnCancel() override { stop_.request_stop(); }
  void OnDone() override { self_.reset(); }  // *this may be gone afterwards

  grpc::ByteBuffer bytes_;  // of the message being read
  MemoryCharge header_charge_ = EmptyCharge();
  grpc::ByteBuffer* const reply_;
  std::optional<QuotaShare> quota_share_;
  StallTimers::Guard sending_;
  std::mutex mutex_;
  bool is_over_ = false;
  std::atomic<bool> is_reading_ = false;
  std::shared_ptr<UploadCall> self_;
};

}  // namespace cwm::server
