#include "server/rpc/call_interceptor.h"

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "server/rpc/runtime.h"
#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;
using grpc::experimental::ServerRpcInfo;

constexpr std::string_view kOwnMethods = "/cwm.v1.";
// These live as long as their client likes, so they are never reported as slow.
constexpr std::string_view kEndless[] = {"/cwm.v1.WorldService/WatchWorld",
                                         "/cwm.v1.PerceptionService/WatchFrames",
                                         "/cwm.v1.RobotService/StreamRobotStates"};

// gRPC passes messages as void*; those of our methods are all raw bytes (messages.h).
std::size_t SizeOf(const void* message) {
  return message == nullptr ? 0 : static_cast<const grpc::ByteBuffer*>(message)->Length();
}

// The interceptor of one call. gRPC calls it once per batch of operations, one after the other.
class CallInterceptor final : public grpc::experimental::Interceptor {
 public:
  CallInterceptor(ServerRpcInfo& info, Runtime& runtime) : info_(info), runtime_(runtime) {}

  void Intercept(InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      request_bytes_ += SizeOf(batch->GetRecvMessage());
    }
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE)) {
      response_bytes_ += SizeOf(batch->GetSendMessage());
    }
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) End(*batch);
    batch->Proceed();  // *this may be gone afterwards
  }

 private:
  bool IsSlow() const {
    if (took() <= kSlowCall) return false;
    return std::ranges::find(kEndless, std::string_view(info_.method())) == std::end(kEndless);
  }
  Clock::duration took() const { return Clock::now() - begin_; }

  void End(InterceptorBatchMethods& batch) {
    const grpc::Status status = batch.GetSendStatus();
    const auto code = static_cast<absl::StatusCode>(status.error_code());
    if (!status.ok()) runtime_.log.Refused(info_.method(), code, ReasonOf(status), Client());
    if (!IsSlow()) return;
    runtime_.log.Slow(info_.method(), code, took(), request_bytes_, response_bytes_);
  }

  // The context may be cast, since all of our methods use the callback API.
  ClientId Client() const {
    return runtime_.ClientOf(
        static_cast<const grpc::CallbackServerContext&>(*info_.server_context()));
  }

  ServerRpcInfo& info_;
  Runtime& runtime_;
  const Clock::time_point begin_ = Clock::now();
  std::size_t request_bytes_ = 0, response_bytes_ = 0;
};

class CallInterceptorFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallInterceptorFactory(Runtime& runtime) : runtime_(runtime) {}

  // gRPC reports unknown methods as bidirectional streams, so they are not intercepted either.
  grpc::experimental::Interceptor* CreateServerInterceptor(ServerRpcInfo* info) override {
    const ServerRpcInfo::Type type = info->type();
    const bool logs_itself =
        type == ServerRpcInfo::Type::UNARY || type == ServerRpcInfo::Type::BIDI_STREAMING;
    if (logs_itself) return nullptr;
    if (!std::string_view(info->method()).starts_with(kOwnMethods)) return nullptr;
    return new CallInterceptor(*info, runtime_);
  }

 private:
  Runtime& runtime_;
};

}  // namespace

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors(Runtime& runtime) {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  creators.push_back(std::make_unique<CallInterceptorFactory>(runtime));
  return creators;
}

}  // namespace cwm::server
