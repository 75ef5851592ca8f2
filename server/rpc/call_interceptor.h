// Sees uploads, exports and watches begin and end, and tells the log of refusals and slow calls.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>
#include <vector>

#include "server/rpc/runtime.h"

namespace cwm::server {

// For the server's builder. `runtime` outlives the server. Unary calls (call.h) and streams of
// questions (stream_queries_call.h) tell the log themselves: gRPC starts a batch more for each message
// that is intercepted, which costs a small question 20 us.
std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors(Runtime& runtime);

}  // namespace cwm::server
