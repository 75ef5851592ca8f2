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
                                     const Request* request, Response* response) {
  const auto work = [&runtime, request, response](const CallContext& call) {
    return Answer(runtime, *request, call, nullptr, response);
  };
  const v1::QueryOptions& options = request->options();
  const double cost_s = EstimatedCost_s(runtime, *request);
  auto await = WhatToAwait(runtime, request->world(), options.world_uid(), options.at_revision());
  if (auto status = CheckCost(cost_s, runtime.application.limits); !status.ok()) await = status;
  return StartUnary(context, runtime, QueueOf(runtime, *request, cost_s), work, std::move(await),
                    LengthOf(*request, cost_s));
}

}  // namespace

QueryService::QueryService(Runtime& runtime) : runtime_(runtime) {
  SetMessageAllocatorFor_CheckCollisions(&check_messages_);
  SetMessageAllocatorFor_GetDistances(&distance_messages_);
  SetMessageAllocatorFor_GetContacts(&contact_messages_);
  SetMessageAllocatorFor_CheckMotions(&motion_messages_);
  SetMessageAllocatorFor_CastRays(&ray_messages_);
  SetMessageAllocatorFor_SamplePoints(&point_messages_);
}

grpc::ServerUnaryReactor* QueryService::CheckCollisions(grpc::CallbackServerContext* context,
                                                        const v1::CheckCollisionsRequest* request,
                                                        v1::CheckCollisionsResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerUnaryReactor* QueryService::GetDistances(grpc::CallbackServerContext* context,
                                                     const v1::GetDistancesRequest* request,
                                                     v1::GetDistancesResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerUnaryReactor* QueryService::GetContacts(grpc::CallbackServerContext* context,
                                                    const v1::GetContactsRequest* request,
                                                    v1::GetContactsResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerUnaryReactor* QueryService::CheckMotions(grpc::CallbackServerContext* context,
                                                     const v1::CheckMotionsRequest* request,
                                                     v1::CheckMotionsResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerUnaryReactor* QueryService::CastRays(grpc::CallbackServerContext* context,
                                                 const v1::CastRaysRequest* request,
                                                 v1::CastRaysResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerUnaryReactor* QueryService::SamplePoints(grpc::CallbackServerContext* context,
                                                     const v1::SamplePointsRequest* request,
                                                     v1::SamplePointsResponse* response) {
  return StartQuery(context, runtime_, request, response);
}

grpc::ServerBidiReactor<v1::StreamQueriesRequest, v1::StreamQueriesResponse>*
QueryService::StreamQueries(grpc::CallbackServerContext* context) {
  return StreamQueriesCall::Start(context, runtime_);
}

}  // namespace cwm::server
