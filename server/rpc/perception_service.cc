#include "server/rpc/perception_service.h"

#include <memory>

#include "server/rpc/call.h"
#include "server/rpc/ingest_call.h"
#include "server/rpc/unary_methods.h"
#include "server/wire/scans.h"

namespace cwm::server {
namespace {

absl::Status List(Application& application, const v1::ListScansRequest& request,
                  v1::ListScansResponse* response) {
  const auto world = application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  response->set_world_uid((*world)->uid());
  for (const KeptScan& scan : (*world)->scans().List()) {
    // The scan's blobs may have been evicted by more recently used ones.
    if (!application.geometry.Get(scan.points.hash).ok()) continue;
    if (!application.geometry.Get(scan.labels.hash).ok()) continue;
    *response->add_scans() = ScanToProto(scan);
  }
  response->set_revision((*world)->Snapshot()->revision().value);  // last: no scan is newer
  return absl::OkStatus();
}

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* PerceptionService::IngestCloud(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return IngestCall::Start(std::make_shared<IngestCall>(context, runtime_, response));
}

grpc::ServerUnaryReactor* PerceptionService::ListScans(grpc::CallbackServerContext* context,
                                                       const grpc::ByteBuffer* request,
                                                       grpc::ByteBuffer* response) {
  return Read<v1::ListScansRequest, v1::ListScansResponse>(
      context, runtime_, request, response,
      [this](const v1::ListScansRequest& parsed, const CallContext&, v1::ListScansResponse* reply) {
        return List(runtime_.application, parsed, reply);
      });
}

}  // namespace cwm::server
