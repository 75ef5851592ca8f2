// cwm.v1.QueryService.
#pragma once

#include "cwm/v1/query.grpc.pb.h"
#include "server/rpc/arena_messages.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class QueryService final : public v1::QueryService::CallbackService {
 public:
  explicit QueryService(Runtime& runtime);

  grpc::ServerUnaryReactor* CheckCollisions(grpc::CallbackServerContext* context,
                                            const v1::CheckCollisionsRequest* request,
                                            v1::CheckCollisionsResponse* response) override;
  grpc::ServerUnaryReactor* GetDistances(grpc::CallbackServerContext* context,
                                         const v1::GetDistancesRequest* request,
                                         v1::GetDistancesResponse* response) override;
  grpc::ServerUnaryReactor* GetContacts(grpc::CallbackServerContext* context,
                                        const v1::GetContactsRequest* request,
                                        v1::GetContactsResponse* response) override;
  grpc::ServerUnaryReactor* CheckMotions(grpc::CallbackServerContext* context,
                                         const v1::CheckMotionsRequest* request,
                                         v1::CheckMotionsResponse* response) override;
  grpc::ServerUnaryReactor* CastRays(grpc::CallbackServerContext* context,
                                     const v1::CastRaysRequest* request,
                                     v1::CastRaysResponse* response) override;
  grpc::ServerUnaryReactor* SamplePoints(grpc::CallbackServerContext* context,
                                         const v1::SamplePointsRequest* request,
                                         v1::SamplePointsResponse* response) override;

 private:
  Runtime& runtime_;
  ArenaMessages<v1::CheckCollisionsRequest, v1::CheckCollisionsResponse> check_messages_;
  ArenaMessages<v1::GetDistancesRequest, v1::GetDistancesResponse> distance_messages_;
  ArenaMessages<v1::GetContactsRequest, v1::GetContactsResponse> contact_messages_;
  ArenaMessages<v1::CheckMotionsRequest, v1::CheckMotionsResponse> motion_messages_;
  ArenaMessages<v1::CastRaysRequest, v1::CastRaysResponse> ray_messages_;
  ArenaMessages<v1::SamplePointsRequest, v1::SamplePointsResponse> point_messages_;
};

}  // namespace cwm::server
