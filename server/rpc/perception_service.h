// cwm.v1.PerceptionService.
#pragma once

#include "cwm/v1/perception.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class PerceptionService final : public v1::PerceptionService::CallbackService {
 public:
  explicit PerceptionService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerReadReactor<v1::IngestCloudRequest>* IngestCloud(
      grpc::CallbackServerContext* context, v1::IngestCloudResponse* response) override;
  grpc::ServerUnaryReactor* ListScans(grpc::CallbackServerContext* context,
                                      const v1::ListScansRequest* request,
                                      v1::ListScansResponse* response) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
