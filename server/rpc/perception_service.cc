#include "server/rpc/perception_service.h"

#include <memory>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/rpc/call.h"
#include "server/rpc/ingest_call.h"
#include "server/rpc/stream_clouds_call.h"
#include "server/rpc/unary_methods.h"
#include "server/rpc/watch_frames_call.h"
#include "server/wire/poses.h"
#include "server/wire/scans.h"
#include "server/wire/sensors.h"

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

absl::Status ListAllSensors(Runtime& runtime, const v1::ListSensorsRequest& request,
                            v1::ListSensorsResponse* response) {
  const auto world = runtime.application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  response->set_world_uid((*world)->uid());
  response->set_revision((*world)->Snapshot()->revision().value);
  const auto live = runtime.live_worlds.Find((*world)->uid());
  if (live == nullptr) return absl::OkStatus();
  for (const SensorStatus& status : live->Sensors()) {
    *response->add_sensors() = SensorToProto(status);
  }
  return absl::OkStatus();
}

absl::Status NoEstimate(const std::string& sensor) {
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      absl::StrCat("use_estimate: too few surfaces determine the pose of the sensor \"", sensor,
                   "\""),
      {.reason = "NO_ESTIMATE", .metadata = {{"sensor", sensor}}});
}

// Sets the pose of frames from now on, and of scans that give none.
absl::Status SetPose(Runtime& runtime, const v1::SetSensorPoseRequest& request,
                     v1::SetSensorPoseResponse* response) {
  const auto world = runtime.application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  const FieldPath root;
  if (auto named = CheckSensorName(request.sensor(), root.Field("sensor")); !named.ok()) {
    return named;
  }
  const auto live = runtime.live_worlds.Find((*world)->uid());
  const bool is_kept = (*world)->SensorPoseOf(request.sensor()).has_value();
  if (!is_kept && (live == nullptr || !live->Has(request.sensor()))) {
    return SensorUnknown(request.sensor());
  }
  absl::StatusOr<Pose> X_WC = NoEstimate(request.sensor());
  if (request.pose_case() == v1::SetSensorPoseRequest::kUseEstimate) {
    if (!request.use_estimate()) {
      return root.Field("use_estimate").Error("is false, must be true");
    }
    const auto estimated = live == nullptr ? std::nullopt : live->EstimatedPose(request.sensor());
    if (estimated) X_WC = *estimated;
  } else if (request.has_x_world_sensor()) {
    X_WC = PoseFromProto(request.x_world_sensor(), root.Field("x_world_sensor"));
  } else {
    return root.Field("pose").Error("is absent, must be one of x_world_sensor, use_estimate");
  }
  if (!X_WC.ok()) return X_WC.status();
  if (live != nullptr && live->Has(request.sensor())) {
    if (auto set = live->SetSensorPose(request.sensor(), *X_WC); !set.ok()) return set;
  }
  const absl::Status kept = (*world)->SetSensorPose(request.sensor(), {*X_WC, true});
  if (!kept.ok()) return kept;
  response->set_world_uid((*world)->uid());
  *response->mutable_x_world_sensor() = PoseToProto(*X_WC);
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

grpc::ServerBidiReactor<grpc::ByteBuffer, grpc::ByteBuffer>* PerceptionService::StreamClouds(
    grpc::CallbackServerContext* context) {
  return StreamCloudsCall::Start(context, runtime_);
}

grpc::ServerUnaryReactor* PerceptionService::ListSensors(grpc::CallbackServerContext* context,
                                                         const grpc::ByteBuffer* request,
                                                         grpc::ByteBuffer* response) {
  return Read<v1::ListSensorsRequest, v1::ListSensorsResponse>(
      context, runtime_, request, response,
      [this](const v1::ListSensorsRequest& parsed, const CallContext&,
             v1::ListSensorsResponse* reply) { return ListAllSensors(runtime_, parsed, reply); });
}

grpc::ServerUnaryReactor* PerceptionService::SetSensorPose(grpc::CallbackServerContext* context,
                                                           const grpc::ByteBuffer* request,
                                                           grpc::ByteBuffer* response) {
  return Write<v1::SetSensorPoseRequest, v1::SetSensorPoseResponse>(
      context, runtime_, request, response,
      [this](const v1::SetSensorPoseRequest& parsed, const CallContext&,
             v1::SetSensorPoseResponse* reply) { return SetPose(runtime_, parsed, reply); });
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* PerceptionService::WatchFrames(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return WatchFramesCall::Start(*context, runtime_, request);
}

}  // namespace cwm::server
