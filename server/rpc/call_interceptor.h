// Observes the begin and end of uploads, exports and watches, and logs refusals and slow calls.
#pragma once

#include <grpcpp/support/server_interceptor.h>

#include <memory>
#include <vector>

#include "server/rpc/runtime.h"

namespace cwm::server {

// For the server's builder. `runtime` must outlive the server. Unary calls (call.h) and query
// streams (stream_queries_call.h) write the log themselves, since gRPC starts one more batch for
// each intercepted message, which costs a small query 20 us.
std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>>
CallInterceptors(Runtime& runtime);

}  // namespace cwm::server
