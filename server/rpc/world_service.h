// cwm.v1.WorldService.
#pragma once

#include "cwm/v1/world.grpc.pb.h"
#include "server/rpc/runtime.h"

namespace cwm::server {

class WorldService final : public v1::WorldService::CallbackService {
 public:
  explicit WorldService(Runtime& runtime);

  grpc::ServerUnaryReactor* ListWorlds(grpc::CallbackServerContext* context,
                                       const v1::ListWorldsRequest* request,
                                       v1::ListWorldsResponse* response) override;
  grpc::ServerUnaryReactor* GetWorld(grpc::CallbackServerContext* context,
                                     const v1::GetWorldRequest* request,
                                     v1::GetWorldResponse* response) override;
  grpc::ServerUnaryReactor* DeleteWorld(grpc::CallbackServerContext* context,
                                        const v1::DeleteWorldRequest* request,
                                        v1::DeleteWorldResponse* response) override;
  grpc::ServerUnaryReactor* ListObjects(grpc::CallbackServerContext* context,
                                        const v1::ListObjectsRequest* request,
                                        v1::ListObjectsResponse* response) override;
  grpc::ServerUnaryReactor* GetObject(grpc::CallbackServerContext* context,
                                      const v1::GetObjectRequest* request,
                                      v1::GetObjectResponse* response) override;
  grpc::ServerUnaryReactor* ApplyChanges(grpc::CallbackServerContext* context,
                                         const v1::ApplyChangesRequest* request,
                                         v1::ApplyChangesResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchWorldResponse>* WatchWorld(
      grpc::CallbackServerContext* context, const v1::WatchWorldRequest* request) override;
  grpc::ServerWriteReactor<v1::ReadGeometryResponse>* ReadGeometry(
      grpc::CallbackServerContext* context, const v1::ReadGeometryRequest* request) override;
  grpc::ServerWriteReactor<v1::ExportWorldResponse>* ExportWorld(
      grpc::CallbackServerContext* context, const v1::ExportWorldRequest* request) override;

 private:
  Runtime& runtime_;
};

}  // namespace cwm::server
