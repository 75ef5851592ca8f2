#include "server/rpc/query_service.h"

#include <utility>

#include "server/rpc/start_query.h"
#include "server/rpc/stream_queries_call.h"

namespace cwm::server {
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

grpc::ServerUnaryReactor* QueryService::GetWorldContacts(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request,
                                                         grpc::ByteBuffer* response) {
  return StartQuery<v1::GetWorldContactsRequest, v1::GetWorldContactsResponse>(context, runtime_,
                                                                               request, response);
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

grpc::ServerUnaryReactor* QueryService::SolvePoses(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  return StartQuery<v1::SolvePosesRequest, v1::SolvePosesResponse>(context, runtime_, request,
                                                                   response);
}

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* QueryService::StreamQueries(
    grpc::CallbackServerContext* context) {
  return StreamQueriesCall::Start(context, runtime_);
}

}  // namespace cwm::server
