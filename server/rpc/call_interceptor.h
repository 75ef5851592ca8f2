// Refuses requests that cannot be parsed: gRPC would answer UNIMPLEMENTED, without a text.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>
#include <vector>

namespace cwm::server {

// For the server's builder. Messages of streams are looked at by the calls (received.h).
std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors();

}  // namespace cwm::server
