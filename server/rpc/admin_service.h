// cwm.v1.AdminService.
#pragma once

#include <atomic>

#include "cwm/v1/admin.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawAdminService = v1::AdminService::WithRawCallbackMethod_GetServerInfo<
    v1::AdminService::WithRawCallbackMethod_GetStats<
        v1::AdminService::WithRawCallbackMethod_BackUp<v1::AdminService::Service>>>;

class AdminService final : public RawAdminService {
 public:
  explicit AdminService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerUnaryReactor* GetServerInfo(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetStats(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* BackUp(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request) override;

 private:
  Runtime& runtime_;
  std::atomic<bool> backs_up_ = false;  // a BackUp is under way
  const Clock::time_point started_ = Clock::now();
};

}  // namespace cwm::server
