// cwm.v1.PerceptionService.
#pragma once

#include "cwm/v1/perception.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class PerceptionService final : public v1::PerceptionService::CallbackService {
 public:
  explicit PerceptionService(Runtime& runtime);

  grpc::ServerUnaryReactor* ListScans(grpc::CallbackServerContext* context,
                                      const v1::ListScansRequest* request,
                                      v1::ListScansResponse* response) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
