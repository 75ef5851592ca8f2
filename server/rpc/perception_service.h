// cwm.v1.PerceptionService.
#pragma once

#include "cwm/v1/perception.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawIngests = v1::PerceptionService::WithRawCallbackMethod_ListScans<
    v1::PerceptionService::WithRawCallbackMethod_IngestCloud<v1::PerceptionService::Service>>;
using RawStreams = v1::PerceptionService::WithRawCallbackMethod_WatchFrames<
    v1::PerceptionService::WithRawCallbackMethod_StreamClouds<RawIngests>>;
using RawPerceptionService = v1::PerceptionService::WithRawCallbackMethod_SetSensorPose<
    v1::PerceptionService::WithRawCallbackMethod_ListSensors<RawStreams>>;

class PerceptionService final : public RawPerceptionService {
 public:
  explicit PerceptionService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerReadReactor<grpc::ByteBuffer>* IngestCloud(grpc::CallbackServerContext* context,
                                                         grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListScans(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* StreamClouds(
      grpc::CallbackServerContext* context) override;
  grpc::ServerUnaryReactor* ListSensors(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* SetSensorPose(grpc::CallbackServerContext* context,
                                          const grpc::ByteBuffer* request,
                                          grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchFrames(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
