// Sees every call but streams of questions begin and end, and tells the log of refusals and slow
// calls.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>
#include <vector>

#include "server/rpc/runtime.h"

namespace cwm::server {

// For the server's builder. `runtime` outlives the server. A stream of questions looks after itself
// (stream_queries_call.h): gRPC starts a batch more for each message that is intercepted.
std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors(Runtime& runtime);

}  // namespace cwm::server
