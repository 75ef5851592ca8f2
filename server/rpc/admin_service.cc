#include "server/rpc/admin_service.h"

#include <algorithm>
#include <string>

#include "collision/engines/engine_version.h"
#include "server/rpc/back_up_call.h"
#include "server/rpc/call.h"

namespace cwm::server {
namespace {

v1::Limits LimitsToProto(const Limits& limits) {
  v1::Limits proto;
  proto.set_max_message_bytes(limits.max_message_bytes);
  proto.set_max_chunk_bytes(limits.max_chunk_bytes);
  proto.set_max_cloud_points(limits.max_cloud_points);
  proto.set_max_mesh_triangles(limits.max_mesh_triangles);
  proto.set_max_batch_rows(limits.max_batch_rows);
  proto.set_max_rows_as_messages(limits.max_rows_as_messages);
  proto.set_max_watchers(std::min(limits.max_watchers, limits.max_client_watchers));
  proto.set_max_metadata_bytes(limits.max_metadata_bytes);
  proto.set_max_streams(std::min(limits.max_streams, limits.max_client_streams));
  proto.set_max_answers(limits.max_answers);
  proto.set_max_answers_as_messages(limits.max_answers_as_messages);
  proto.set_max_object_bytes(limits.max_object_bytes);
  proto.set_max_robot_bytes(limits.max_robot_bytes);
  proto.set_max_robot_files(limits.max_robot_files);
  proto.set_max_robot_links(limits.robot.max_links);
  proto.set_max_robot_triangles(static_cast<std::int64_t>(limits.robot.max_triangles));
  proto.set_max_robots(limits.max_robots);
  proto.set_max_watchers_in_all(limits.max_watchers);
  proto.set_max_streams_in_all(limits.max_streams);
  proto.set_max_uploads_in_all(limits.max_uploads);
  proto.set_max_uploads(std::min(limits.max_uploads, limits.max_client_uploads));
  proto.set_max_waits_in_all(limits.max_waits);
  proto.set_max_waits(std::min(limits.max_waits, limits.max_client_waits));
  proto.set_max_stall_seconds(std::chrono::duration<double>(limits.max_stall).count());
  proto.set_max_worlds(limits.max_worlds);
  proto.set_max_objects(limits.max_objects);
  proto.set_max_parts(limits.max_parts);
  proto.set_max_calls_of_connection(MaxCallsOfConnection(limits));
  return proto;
}

void SetConnectionLimits(const Runtime& runtime, v1::Limits& proto) {
  const ConnectionLimits& limits = runtime.connections.limits();
  const TransportLimits& transport = runtime.application.transport;
  proto.set_max_connections(limits.all);
  proto.set_max_connections_of_user(limits.of_user);
  proto.set_max_silent_connections(limits.silent_of_user);
  proto.set_max_silence_seconds(std::chrono::duration<double>(transport.max_silence).count());
}

v1::Retention RetentionToProto(const Retention& retention) {
  v1::Retention proto;
  proto.set_exact_snapshots(retention.exact_snapshots);
  proto.set_watch_events(retention.watch_events);
  proto.set_watch_seconds(std::chrono::duration<double>(retention.watch_time).count());
  proto.set_request_id_seconds(std::chrono::duration<double>(retention.request_id_time).count());
  return proto;
}

v1::StoreInfo StoreToProto(const Application& application) {
  v1::StoreInfo proto;
  proto.set_replayed(application.gate.progress());
  proto.set_replay_seconds(application.gate.closed_s());
  const StoreAdmin* const store = application.store_admin;
  if (store == nullptr) return proto;
  const StoreInfo info = store->info();
  proto.set_sequence(info.sequence);
  proto.set_epoch(info.epoch);
  proto.set_record_count(info.record_count);
  proto.set_bytes(info.bytes);
  proto.set_blob_count(info.blob_count);
  proto.set_refuses_writes(info.refuses_writes);
  return proto;
}

absl::Status Describe(const Runtime& runtime, Clock::time_point started,
                      v1::GetServerInfoResponse* response) {
  const Application& application = runtime.application;
  response->set_version(CWM_VERSION);
  *response->mutable_limits() = LimitsToProto(application.limits);
  SetConnectionLimits(runtime, *response->mutable_limits());
  response->mutable_limits()->set_max_memory_bytes(application.memory->limit_bytes());
  response->mutable_limits()->set_max_world_memory_bytes(application.memory->worlds_limit_bytes());
  *response->mutable_retention() = RetentionToProto(application.retention);
  for (int i = 0; i < collision::kEngineCount; ++i) {
    const auto kind = static_cast<collision::EngineKind>(i);
    v1::EngineInfo* engine = response->add_engines();
    engine->set_name(std::string(collision::NameOf(kind)));
    engine->set_version(kind == collision::EngineKind::kExact ? CWM_VERSION
                                                              : collision::EngineVersion(kind));
  }
  response->set_uptime_s(std::chrono::duration<double>(Clock::now() - started).count());
  response->set_store(application.store);
  if (application.store != kMemoryStore)
    *response->mutable_store_info() = StoreToProto(application);
  return absl::OkStatus();
}

}  // namespace

// A query about the server's state must not wait for its work.
grpc::ServerUnaryReactor* AdminService::GetServerInfo(grpc::CallbackServerContext* context,
                                                      const grpc::ByteBuffer* request,
                                                      grpc::ByteBuffer* response) {
  return StartUnary<v1::GetServerInfoRequest, v1::GetServerInfoResponse>(
      context, runtime_, request, response, runtime_.reads,
      {.plan =
           [](const v1::GetServerInfoRequest&) {
             return UnaryPlan{.length = WorkLength::kImmediate};
           },
       .work =
           [this](const v1::GetServerInfoRequest&, const CallContext&,
                  v1::GetServerInfoResponse* reply) { return Describe(runtime_, started_, reply); },
       .is_always_served = true});
}

grpc::ServerUnaryReactor* AdminService::GetStats(grpc::CallbackServerContext* context,
                                                 const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return StartUnary<v1::GetStatsRequest, v1::GetStatsResponse>(
      context, runtime_, request, response, runtime_.reads,
      {.plan =
           [](const v1::GetStatsRequest&) { return UnaryPlan{.length = WorkLength::kImmediate}; },
       .work =
           [this](const v1::GetStatsRequest&, const CallContext&, v1::GetStatsResponse* reply) {
             reply->set_connections_open(runtime_.connections.open());
             reply->set_connections_shed(runtime_.connections.shed());
             const MemoryBudget& memory = *runtime_.application.memory;
             reply->set_memory_clients_bytes(memory.client_bytes());
             reply->set_memory_worlds_bytes(memory.world_bytes());
             reply->set_watchers(runtime_.watchers.taken());
             reply->set_streams(runtime_.streams.taken());
             reply->set_uploads(runtime_.uploads.taken());
             return absl::OkStatus();
           },
       .is_always_served = true});
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* AdminService::BackUp(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return BackUpCall::Start(*context, runtime_, request, backs_up_);
}

}  // namespace cwm::server
