// cwm.v1.WorldService.
#pragma once

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

// Messages of raw methods are parsed by our own code (messages.h).
using RawWorldService = v1::WorldService::WithRawCallbackMethod_ListWorlds<
    v1::WorldService::WithRawCallbackMethod_GetWorld<
        v1::WorldService::WithRawCallbackMethod_DeleteWorld<
            v1::WorldService::WithRawCallbackMethod_ListObjects<
                v1::WorldService::WithRawCallbackMethod_GetObject<
                    v1::WorldService::WithRawCallbackMethod_ApplyChanges<
                        v1::WorldService::WithRawCallbackMethod_WriteGeometry<
                            v1::WorldService::WithRawCallbackMethod_ExportWorld<
                                v1::WorldService::WithRawCallbackMethod_ReadGeometry<
                                    v1::WorldService::WithRawCallbackMethod_WatchWorld<
                                        v1::WorldService::Service>>>>>>>>>>;

class WorldService final : public RawWorldService {
 public:
  explicit WorldService(Runtime& runtime) : runtime_(runtime) {}

  grpc::ServerUnaryReactor* ListWorlds(grpc::CallbackServerContext* context,
                                       const grpc::ByteBuffer* request,
                                       grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetWorld(grpc::CallbackServerContext* context,
                                     const grpc::ByteBuffer* request,
                                     grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* DeleteWorld(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ListObjects(grpc::CallbackServerContext* context,
                                        const grpc::ByteBuffer* request,
                                        grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* GetObject(grpc::CallbackServerContext* context,
                                      const grpc::ByteBuffer* request,
                                      grpc::ByteBuffer* response) override;
  grpc::ServerUnaryReactor* ApplyChanges(grpc::CallbackServerContext* context,
                                         const grpc::ByteBuffer* request,
                                         grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* WatchWorld(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* ReadGeometry(
      grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) override;
  grpc::ServerReadReactor<grpc::ByteBuffer>* WriteGeometry(grpc::CallbackServerContext* context,
                                                           grpc::ByteBuffer* response) override;
  grpc::ServerWriteReactor<grpc::ByteBuffer>* ExportWorld(grpc::CallbackServerContext* context,
                                                          const grpc::ByteBuffer* request) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
