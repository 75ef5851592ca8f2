// A call whose client sends messages until it is done, after which the work begins.
#pragma once

#include <grpcpp/grpcpp.h>

#include <memory>
#include <mutex>
#include <stop_token>
#include <utility>

#include "server/rpc/call.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {

// Messages are read one at a time. While one is awaited a draining server ends the call; once the
// last has come, the task that does the work is the only one that finishes it.
template <class Request>
class UploadCall : public grpc::ServerReadReactor<Request>, public Drainable {
 public:
  // The call owns itself until gRPC is done with it.
  static UploadCall* Start(const std::shared_ptr<UploadCall>& call) {
    call->self_ = call;
    call->ReadNext();
    call->runtime_.AddDrainable(call);
    return call.get();
  }

  void Drain() final {
    const std::lock_guard lock(mutex_);
    if (std::exchange(is_reading_, false)) this->Finish(ToGrpcStatus(Draining()));
  }

 protected:
  explicit UploadCall(Runtime& runtime) : runtime_(runtime) {}

  // The message has come; where `ok` is false none comes any more. Ends in ReadNext, Finish or, on
  // another thread, FinishWith.
  virtual void OnMessage(bool ok) = 0;

  void ReadNext() {
    {
      const std::lock_guard lock(mutex_);  // gRPC does not react within StartRead
      if (!runtime_.draining()) {
        is_reading_ = true;
        return this->StartRead(&message_);
      }
    }
    this->Finish(ToGrpcStatus(Draining()));
  }

  // Does the work and finishes the call, which may be gone after it. What has not begun when the
  // server drains is not done.
  void FinishWith(const CallWork& work, const CallContext& call) {
    const absl::Status status = runtime_.draining() ? Draining() : RunGuarded(work, call);
    this->Finish(ToGrpcStatus(WhyItEnded(status, runtime_)));
  }

  Runtime& runtime_;
  std::stop_source stop_;
  Request message_;

 private:
  void OnReadDone(bool ok) final {
    {
      const std::lock_guard lock(mutex_);
      if (!std::exchange(is_reading_, false)) return;  // the drain was first
    }
    OnMessage(ok);
  }
  void OnCancel() final { stop_.request_stop(); }
  void OnDone() final { self_.reset(); }  // *this may be gone after it

  const OpenCalls::Token open_{runtime_.open_calls, stop_};
  std::shared_ptr<UploadCall> self_;  // until OnDone
  std::mutex mutex_;
  bool is_reading_ = false;
};

}  // namespace cwm::server
