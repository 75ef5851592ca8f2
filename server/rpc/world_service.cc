#include "server/rpc/world_service.h"

#include <utility>

#include "proto/transfer/sha256.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/geometry_calls.h"
#include "server/rpc/object_pages.h"
#include "server/rpc/watch_call.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/questions.h"

namespace cwm::server {
namespace {

v1::World WorldMessage(const World& world) {
  const SnapshotPtr snapshot = world.Snapshot();
  v1::World proto;
  proto.set_name(world.name());
  proto.set_world_uid(world.uid());
  proto.set_revision(snapshot->revision().value);
  proto.set_object_count(static_cast<std::int64_t>(snapshot->objects().size()));
  proto.set_oldest_exact_revision(world.oldest_exact().value);
  proto.set_oldest_watch_revision(world.oldest_watch().value);
  return proto;
}

absl::StatusOr<WriteOptions> WriteOptionsOf(v1::ApplyChangesRequest request) {
  constexpr std::int64_t kMostIdBytes = 128;
  const FieldPath root;
  WriteOptions options;
  if (request.has_expected_revision()) {
    options.expected_revision = collision::Revision{request.expected_revision()};
  }
  if (request.request_id().empty()) return options;
  auto status = CheckTextLength(request.request_id(), kMostIdBytes, root.Field("request_id"));
  if (!status.ok()) return status;
  options.request_id = request.request_id();
  request.clear_request_id();
  options.request_digest = Sha256Hex(request.SerializeAsString());
  return options;
}

// A named uid must match, so that such a write never makes a world.
absl::StatusOr<std::shared_ptr<World>> WorldToWrite(WorldRegistry& worlds,
                                                    const v1::ApplyChangesRequest& request) {
  if (!request.world_uid().empty()) return worlds.Find(request.world(), request.world_uid());
  return worlds.FindOrCreate(request.world());
}

absl::Status ApplyRequest(Application& application, const v1::ApplyChangesRequest& request,
                          v1::ApplyChangesResponse* response) {
  auto options = WriteOptionsOf(request);
  if (!options.ok()) return options.status();
  auto changes = FromProto(request.changes(), application.limits, application.geometry, {});
  if (!changes.ok()) return changes.status();
  auto world = WorldToWrite(application.worlds, request);
  if (!world.ok()) return world.status();
  auto outcome = (*world)->Apply(*changes, *options);
  if (!outcome.ok()) return outcome.status();
  response->set_world_uid((*world)->uid());
  response->set_revision(outcome->revision.value);
  return absl::OkStatus();
}

absl::Status Get(Runtime& runtime, const v1::GetObjectRequest& request, const CallContext& call,
                 v1::GetObjectResponse* response) {
  const FieldPath root;
  auto view = FromProto(request.view(), View::kFull, root.Field("view"));
  if (!view.ok()) return view.status();
  if (auto status = CheckName(request.name(), root.Field("name")); !status.ok()) return status;
  auto rule = FromProto(request.at_revision(), root.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  auto at = FindWorldAt(runtime, request.world(), request.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  const collision::WorldObjectPtr object = at->snapshot->Find(request.name());
  if (object == nullptr) return UnknownObject(request.name());
  response->set_world_uid(at->world->uid());
  response->set_revision(at->snapshot->revision().value);
  *response->mutable_object() =
      ToProto(*object, *view, at->world->LastObserved(object->name), runtime.application.geometry);
  return absl::OkStatus();
}

}  // namespace

grpc::ServerUnaryReactor* WorldService::ListWorlds(grpc::CallbackServerContext* context,
                                                   const v1::ListWorldsRequest*,
                                                   v1::ListWorldsResponse* response) {
  return StartUnary(context, runtime_, runtime_.control, [this, response](const CallContext&) {
    for (const auto& world : runtime_.application.worlds.List()) {
      *response->add_worlds() = WorldMessage(*world);
    }
    return absl::OkStatus();
  });
}

grpc::ServerUnaryReactor* WorldService::GetWorld(grpc::CallbackServerContext* context,
                                                 const v1::GetWorldRequest* request,
                                                 v1::GetWorldResponse* response) {
  return StartUnary(context, runtime_, runtime_.control,
                    [this, request, response](const CallContext&) {
                      auto world = runtime_.application.worlds.Find(request->world());
                      if (!world.ok()) return world.status();
                      *response->mutable_world() = WorldMessage(**world);
                      response->set_world_uid(response->world().world_uid());
                      response->set_revision(response->world().revision());
                      return absl::OkStatus();
                    });
}

grpc::ServerUnaryReactor* WorldService::DeleteWorld(grpc::CallbackServerContext* context,
                                                    const v1::DeleteWorldRequest* request,
                                                    v1::DeleteWorldResponse* response) {
  return StartUnary(
      context, runtime_, runtime_.control, [this, request, response](const CallContext&) {
        auto world = runtime_.application.worlds.Delete(request->world(), request->world_uid());
        if (!world.ok()) return world.status();
        response->set_world_uid((*world)->uid());
        response->set_revision((*world)->Snapshot()->revision().value);
        return absl::OkStatus();
      });
}

grpc::ServerUnaryReactor* WorldService::ListObjects(grpc::CallbackServerContext* context,
                                                    const v1::ListObjectsRequest* request,
                                                    v1::ListObjectsResponse* response) {
  return StartUnary(
      context, runtime_, runtime_.control,
      [this, request, response](const CallContext& call) {
        return ListPage(runtime_, *request, call, response);
      },
      WhatToAwait(runtime_, request->world(), request->world_uid(), request->at_revision()));
}

grpc::ServerUnaryReactor* WorldService::GetObject(grpc::CallbackServerContext* context,
                                                  const v1::GetObjectRequest* request,
                                                  v1::GetObjectResponse* response) {
  return StartUnary(
      context, runtime_, runtime_.control,
      [this, request, response](const CallContext& call) {
        return Get(runtime_, *request, call, response);
      },
      WhatToAwait(runtime_, request->world(), request->world_uid(), request->at_revision()));
}

grpc::ServerUnaryReactor* WorldService::ApplyChanges(grpc::CallbackServerContext* context,
                                                     const v1::ApplyChangesRequest* request,
                                                     v1::ApplyChangesResponse* response) {
  return StartUnary(context, runtime_, runtime_.control,
                    [this, request, response](const CallContext&) {
                      return ApplyRequest(runtime_.application, *request, response);
                    });
}

grpc::ServerWriteReactor<v1::WatchWorldResponse>* WorldService::WatchWorld(
    grpc::CallbackServerContext*, const v1::WatchWorldRequest* request) {
  return WatchCall::Start(runtime_, *request);
}

grpc::ServerWriteReactor<v1::ReadGeometryResponse>* WorldService::ReadGeometry(
    grpc::CallbackServerContext*, const v1::ReadGeometryRequest* request) {
  return new ReadGeometryCall(runtime_, *request);
}

grpc::ServerReadReactor<v1::WriteGeometryRequest>* WorldService::WriteGeometry(
    grpc::CallbackServerContext*, v1::WriteGeometryResponse* response) {
  return new WriteGeometryCall(runtime_, response);
}

}  // namespace cwm::server
