#include "server/rpc/query_service.h"

#include <utility>

#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/query_answers.h"
#include "server/rpc/query_queue.h"
#include "server/rpc/stream_queries_call.h"

namespace cwm::server {
namespace {

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

}  // namespace

grpc::ServerUnaryReactor* QueryService::CheckCollisions(grpc::CallbackServerContext* context,
                                                        const grpc::ByteBuffer* request,
                                                        grpc::ByteBuffer* response) {
  return StartQuery<v1::CheckCollisionsRequest, v1::CheckCollisionsResponse>(context, runtime_,
                                                                             request, response);
}

grpc::ServerUnaryReactor* QueryService::GetDistances(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request,
                                                     grpc::ByteBuffer* response) {
  return StartQuery<v1::GetDistancesRequest, v1::GetDistancesResponse>(context, runtime_, request,
                                                                       response);
}

grpc::ServerUnaryReactor* QueryService::GetContacts(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return StartQuery<v1::GetContactsRequest, v1::GetContactsResponse>(context, runtime_, request,
                                                                     response);
}

grpc::ServerUnaryReactor* QueryService::CheckMotions(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request,
                                                     grpc::ByteBuffer* response) {
  return StartQuery<v1::CheckMotionsRequest, v1::CheckMotionsResponse>(context, runtime_, request,
                                                                       response);
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* context,
                                                 const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return StartQuery<v1::CastRaysRequest, v1::CastRaysResponse>(context, runtime_, request,
                                                               response);
}

grpc::ServerUnaryReactor* QueryService::SamplePoints(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request,
                                                     grpc::ByteBuffer* response) {
  return StartQuery<v1::SamplePointsRequest, v1::SamplePointsResponse>(context, runtime_, request,
                                                                       response);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* QueryService::StreamQueries(
    grpc::CallbackServerContext* context) {
  return StreamQueriesCall::Start(context, runtime_);
}

}  // namespace cwm::server
