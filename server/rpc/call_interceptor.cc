#include "server/rpc/call_interceptor.h"

#include <grpcpp/grpcpp.h>

#include <string_view>

#include "server/rpc/status_conversion.h"

namespace cwm::server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;
using grpc::experimental::ServerRpcInfo;

constexpr std::string_view kOwnMethods = "/cwm.v1.";

// One call's. gRPC calls it once for each batch of operations, one after the other.
class CallInterceptor final : public grpc::experimental::Interceptor {
 public:
  explicit CallInterceptor(ServerRpcInfo& info) : info_(info) {}

  void Intercept(InterceptorBatchMethods* batch) override {
    if (batch->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE)) {
      is_malformed_ = batch->GetRecvMessage() == nullptr;
    }
    if (is_malformed_ &&
        batch->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS)) {
      batch->ModifySendStatus(ToGrpcStatus(MalformedRequest(info_.method())));
    }
    batch->Proceed();  // *this may be gone after it
  }

 private:
  ServerRpcInfo& info_;
  bool is_malformed_ = false;
};

class CallInterceptorFactory final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  // Methods that nobody has come here as streams both ways.
  grpc::experimental::Interceptor* CreateServerInterceptor(ServerRpcInfo* info) override {
    const bool has_one_request = info->type() == ServerRpcInfo::Type::UNARY ||
                                 info->type() == ServerRpcInfo::Type::SERVER_STREAMING;
    if (!has_one_request || !std::string_view(info->method()).starts_with(kOwnMethods)) {
      return nullptr;
    }
    return new CallInterceptor(*info);
  }
};

}  // namespace

std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors() {
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> creators;
  creators.push_back(std::make_unique<CallInterceptorFactory>());
  return creators;
}

}  // namespace cwm::server
