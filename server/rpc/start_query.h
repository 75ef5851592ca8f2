// Starts the unary call of a query: its queue, the revision it waits for, its cost and its answer.
#pragma once

#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/query_answers.h"
#include "server/rpc/query_queue.h"

namespace cwm::server {

template <class Request, class Response>
grpc::ServerUnaryReactor* StartQuery(grpc::CallbackServerContext* context, Runtime& runtime,
                                     const grpc::ByteBuffer* request, grpc::ByteBuffer* response) {
  return StartUnary<Request, Response>(
      context, runtime, request, response, runtime.batches,
      {.plan =
           [&runtime](const Request& parsed) {
             const v1::QueryOptions& options = parsed.options();
             const double cost_s = EstimatedCost_s(runtime, parsed);
             UnaryPlan plan{
                 .queue = &QueueOf(runtime, parsed, cost_s),
                 .await = FindRevisionToAwait(runtime, parsed.world(), options.world_uid(),
                                              options.at_revision()),
                 .length = LengthOf(parsed, cost_s),
                 .cost_s = cost_s,
                 .allows_partial_answer = true};
             const absl::Status affordable = CheckCost(cost_s, runtime.application.limits);
             if (!affordable.ok()) plan.await = affordable;
             return plan;
           },
       .work =
           [&runtime](const Request& parsed, const CallContext& call, Response* reply) {
             return AnswerQuery(runtime, parsed, call, nullptr, reply);
           }});
}

}  // namespace cwm::server
