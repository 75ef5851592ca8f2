// cwm.v1.AdminService.
#pragma once

#include "cwm/v1/admin.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class AdminService final : public v1::AdminService::CallbackService {
 public:
  explicit AdminService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const v1::GetServerInfoRequest* request,
                                          v1::GetServerInfoResponse* response) override;
  grpc::ServerUnaryReactor* GetStats(grpc::CallbackServerContext* context,
                                     const v1::GetStatsRequest* request,
                                     v1::GetStatsResponse* response) override;

 private:
  Runtime& runtime_;
  const Clock::time_point started_ = Clock::now();
};

}  // namespace cwm::server
