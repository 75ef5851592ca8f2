#include "server/rpc/perception_service.h"

#include "server/rpc/call.h"
#include "server/rpc/ingest_call.h"
#include "server/wire/scans.h"

namespace cwm::server {
namespace {

absl::Status List(Application& application, const v1::ListScansRequest& request,
                  v1::ListScansResponse* response) {
  const auto world = application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  response->set_world_uid((*world)->uid());
  for (const KeptScan& scan : (*world)->scans().List()) {
    // Blobs that were used since may have taken its room.
    if (!application.geometry.Get(scan.points.hash).ok()) continue;
    if (!application.geometry.Get(scan.labels.hash).ok()) continue;
    *response->add_scans() = ToProto(scan);
  }
  response->set_revision((*world)->Snapshot()->revision().value);  // no scan is newer
  return absl::OkStatus();
}

}  // namespace

grpc::ServerReadReactor<v1::IngestCloudRequest>* PerceptionService::IngestCloud(
    grpc::CallbackServerContext* context, v1::IngestCloudResponse* response) {
  return IngestCall::Start(std::make_shared<IngestCall>(context, runtime_, response));
}

grpc::ServerUnaryReactor* PerceptionService::ListScans(grpc::CallbackServerContext* context,
                                                       const v1::ListScansRequest* request,
                                                       v1::ListScansResponse* response) {
  return StartUnary(context, runtime_, runtime_.reads,
                    [this, request, response](const CallContext&) {
                      return List(runtime_.application, *request, response);
                    });
}

}  // namespace cwm::server
