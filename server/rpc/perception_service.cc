#include "server/rpc/perception_service.h"

#include "server/rpc/ingest_call.h"

namespace cwm::server {

grpc::ServerReadReactor<v1::IngestCloudRequest>* PerceptionService::IngestCloud(
    grpc::CallbackServerContext* context, v1::IngestCloudResponse* response) {
  return new IngestCall(context, runtime_, response);
}

}  // namespace cwm::server
