// cwm.v1.PerceptionService.
#pragma once

#include "cwm/v1/perception.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawPerceptionService = v1::PerceptionService::WithRawCallbackMethod_ListScans<
    v1::PerceptionService::WithRawCallbackMethod_IngestCloud<v1::PerceptionService::Service>>;

class PerceptionService final : public RawPerceptionService {
 public:
  explicit PerceptionService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerReadReactor<grpc::ByteBuffer>* IngestCloud(grpc::CallbackServerContext* context,
                                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListScans(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
