#include "server/rpc/world_service.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "proto/transfer/sha256.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/export_call.h"
#include "server/rpc/geometry_calls.h"
#include "server/rpc/object_pages.h"
#include "server/rpc/query_queue.h"
#include "server/rpc/unary_methods.h"
#include "server/rpc/watch_call.h"
#include "server/wire/numbers.h"
#include "server/wire/objects.h"
#include "server/wire/pair_rules.h"
#include "server/wire/prepared_bytes.h"
#include "server/wire/queries.h"

namespace cwm::server {
namespace {

v1::World WorldMessage(const World& world, const collision::WorldSnapshot& latest) {
  v1::World proto;
  proto.set_name(world.name());
  proto.set_world_uid(world.uid());
  proto.set_revision(latest.revision().value);
  proto.set_object_count(static_cast<std::int64_t>(latest.objects().size()));
  proto.set_robot_count(static_cast<std::int64_t>(latest.robots().size()));
  proto.set_oldest_exact_revision(world.oldest_exact().value);
  proto.set_oldest_watch_revision(world.oldest_watch().value);
  return proto;
}

absl::Status CheckRequestId(const std::string& request_id) {
  constexpr std::int64_t kMaxIdBytes = 128;
  const FieldPath root;
  return CheckTextLength(request_id, kMaxIdBytes, root.Field("request_id"));
}

// The same for a retry. Computed change by change, since a request of 16 MiB takes tens of
// milliseconds.
std::string DigestOf(const v1::ApplyChangesRequest& request, WorkBudget& budget) {
  constexpr std::size_t kBytesOfStep = 16;
  Sha256 digest;
  const auto add = [&digest](const std::string& text) {
    const std::uint64_t size = text.size();
    digest.Add(&size, sizeof(size));
    digest.Add(text.data(), text.size());
  };
  add(request.world());
  add(request.world_uid());
  add(request.has_expected_revision() ? std::to_string(request.expected_revision()) : "");
  for (const v1::Change& change : request.changes()) {
    const std::string text = change.SerializeAsString();
    add(text);
    if (budget.MustEndAfter(1 + text.size() / kBytesOfStep)) break;
  }
  return digest.Hex();
}

absl::StatusOr<WriteOptions> WriteOptionsOf(const v1::ApplyChangesRequest& request,
                                            WorkBudget& budget) {
  WriteOptions options;
  if (request.has_expected_revision()) {
    options.expected_revision = collision::Revision{request.expected_revision()};
  }
  if (request.request_id().empty()) return options;
  if (auto status = CheckRequestId(request.request_id()); !status.ok()) return status;
  options.request_id = request.request_id();
  options.request_digest = DigestOf(request, budget);
  if (HasEnded(&budget)) return budget.status();
  return options;
}

bool Puts(const collision::Change& change) {
  return std::holds_alternative<collision::PutObject>(change.what);
}

void SetReply(const World& world, const WriteOutcome& outcome, v1::ApplyChangesResponse* response) {
  response->set_world_uid(world.uid());
  response->set_revision(outcome.revision.value);
}

// Only a list that puts something creates a world, and only when it is applied.
absl::Status StartApplyTo(WorldRegistry& worlds, const v1::ApplyChangesRequest& request,
                          const std::vector<collision::Change>& changes,
                          const WriteOptions& options, WorkBudget& budget,
                          v1::ApplyChangesResponse* response, const EndCall& end) {
  if (std::none_of(changes.begin(), changes.end(), Puts)) {
    auto world = worlds.Find(request.world(), request.world_uid());
    if (!world.ok()) return world.status();
  }
  auto acquired = worlds.AcquireLease(request.world(), request.world_uid());
  if (!acquired.ok()) return acquired.status();
  const auto lease = std::make_shared<WorldRegistry::Lease>(*std::move(acquired));
  World& world = **lease;
  world.StartApply(changes, options, &budget,
                   [lease, response, end](const absl::StatusOr<WriteOutcome>& outcome) {
                     if (!outcome.ok()) return end(outcome.status());
                     SetReply(**lease, *outcome, response);
                     end(absl::OkStatus());
                   });
  return absl::OkStatus();
}

absl::Status Delete(Runtime& runtime, const v1::DeleteWorldRequest& request,
                    v1::DeleteWorldResponse* response) {
  if (auto status = CheckRequestId(request.request_id()); !status.ok()) return status;
  auto deleted =
      runtime.application.worlds.Delete(request.world(), request.world_uid(), request.request_id());
  if (!deleted.ok()) return deleted.status();
  response->set_world_uid(deleted->uid);
  response->set_revision(deleted->revision.value);
  runtime.ScheduleMemoryReturn();
  return absl::OkStatus();
}

// OK if `end` was called or will be.
absl::Status StartApply(Application& application, const v1::ApplyChangesRequest& request,
                        const CallContext& call, v1::ApplyChangesResponse* response,
                        const EndCall& end) {
  WorkBudget budget(call.deadline, call.stop);
  auto options = WriteOptionsOf(request, budget);
  if (!options.ok()) return options.status();
  if (const auto known = application.worlds.Find(request.world(), request.world_uid());
      known.ok()) {
    // A retry gets the first reply even if the objects it names are gone.
    const bool is_decided = (*known)->StartPrecheck(
        *options, [world = *known, response, end](const absl::StatusOr<WriteOutcome>& outcome) {
          if (outcome.ok()) SetReply(*world, *outcome, response);
          end(outcome.status());
        });
    if (is_decided) return absl::OkStatus();
  }
  // Prepared geometry is charged to the client until it is charged to the world.
  const auto prepared = application.memory->Charge(
      MemoryBudget::Client(call.client), PreparedBytes(request.changes(), application.geometry));
  if (!prepared.ok()) return prepared.status();
  auto changes = ChangesFromProto(request.changes(), application.limits, application.geometry, {},
                                  "changes", &budget);
  if (!changes.ok()) return changes.status();
  return StartApplyTo(application.worlds, request, *changes, *options, budget, response, end);
}

absl::Status ReadObject(Runtime& runtime, const v1::GetObjectRequest& request,
                        const CallContext& call, v1::GetObjectResponse* response) {
  const FieldPath root;
  auto view = ViewFromProto(request.view(), View::kFull, root.Field("view"));
  if (!view.ok()) return view.status();
  if (auto status = CheckName(request.name(), root.Field("name")); !status.ok()) return status;
  auto rule = RevisionRuleFromProto(request.at_revision(), root.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  auto at = FindWorldAt(runtime, request.world(), request.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  const collision::WorldObjectPtr object = at->snapshot->Find(request.name());
  if (object == nullptr) return UnknownObject(request.name());
  response->set_world_uid(at->world->uid());
  response->set_revision(at->snapshot->revision().value);
  *response->mutable_object() = ObjectToProto(
      *object, *view, at->world->observations().Get(object->name), runtime.application.geometry);
  return absl::OkStatus();
}

absl::Status DescribeWorld(Runtime& runtime, const v1::GetWorldRequest& request,
                           const CallContext& call, v1::GetWorldResponse* response) {
  auto rule = RevisionRuleFromProto(request.at_revision(), FieldPath::OfRequest("at_revision"));
  if (!rule.ok()) return rule.status();
  auto at = FindWorldAt(runtime, request.world(), "", *rule, call);
  if (!at.ok()) return at.status();
  *response->mutable_world() = WorldMessage(*at->world, *at->snapshot);
  response->set_world_uid(response->world().world_uid());
  response->set_revision(response->world().revision());
  for (const collision::PairRule& pair : at->snapshot->pair_rules()) {
    *response->add_pair_rules() = PairRuleToProto(pair);
  }
  return absl::OkStatus();
}

}  // namespace

grpc::ServerUnaryReactor* WorldService::ListWorlds(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  return Read<v1::ListWorldsRequest, v1::ListWorldsResponse>(
      context, runtime_, request, response,
      [this](const v1::ListWorldsRequest&, const CallContext&, v1::ListWorldsResponse* reply) {
        for (const auto& world : runtime_.application.worlds.List()) {
          *reply->add_worlds() = WorldMessage(*world, *world->Snapshot());
        }
        return absl::OkStatus();
      });
}

grpc::ServerUnaryReactor* WorldService::GetWorld(grpc::CallbackServerContext* context,
                                                 const grpc::ByteBuffer* request,
                                                 grpc::ByteBuffer* response) {
  return Read<v1::GetWorldRequest, v1::GetWorldResponse>(
      context, runtime_, request, response,
      [this](const v1::GetWorldRequest& parsed, const CallContext& call,
             v1::GetWorldResponse* reply) { return DescribeWorld(runtime_, parsed, call, reply); });
}

grpc::ServerUnaryReactor* WorldService::ListObjects(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return Read<v1::ListObjectsRequest, v1::ListObjectsResponse>(
      context, runtime_, request, response,
      [this](const v1::ListObjectsRequest& parsed, const CallContext& call,
             v1::ListObjectsResponse* reply) { return ListPage(runtime_, parsed, call, reply); });
}

grpc::ServerUnaryReactor* WorldService::GetObject(grpc::CallbackServerContext* context,
                                                  const grpc::ByteBuffer* request,
                                                  grpc::ByteBuffer* response) {
  return Read<v1::GetObjectRequest, v1::GetObjectResponse>(
      context, runtime_, request, response,
      [this](const v1::GetObjectRequest& parsed, const CallContext& call,
             v1::GetObjectResponse* reply) { return ReadObject(runtime_, parsed, call, reply); });
}

grpc::ServerUnaryReactor* WorldService::DeleteWorld(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return Write<v1::DeleteWorldRequest, v1::DeleteWorldResponse>(
      context, runtime_, request, response,
      [this](const v1::DeleteWorldRequest& parsed, const CallContext&,
             v1::DeleteWorldResponse* reply) { return Delete(runtime_, parsed, reply); });
}

grpc::ServerUnaryReactor* WorldService::ApplyChanges(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request,
                                                     grpc::ByteBuffer* response) {
  return StartUnary<v1::ApplyChangesRequest, v1::ApplyChangesResponse>(
      context, runtime_, request, response, runtime_.batches,
      {.plan =
           [this](const v1::ApplyChangesRequest& parsed) {
             const double cost_s = EstimatedCost_s(runtime_, parsed);
             UnaryPlan plan{.queue = &WriteQueueFor(runtime_, cost_s), .cost_s = cost_s};
             const absl::Status affordable = CheckCost(cost_s, runtime_.application.limits);
             if (!affordable.ok()) plan.await = affordable;
             return plan;
           },
       .start =
           [this](const v1::ApplyChangesRequest& parsed, const CallContext& call,
                  v1::ApplyChangesResponse* reply, const EndCall& end) {
             const absl::Status started =
                 StartApply(runtime_.application, parsed, call, reply, end);
             if (!started.ok()) end(started);
           }});
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* WorldService::WatchWorld(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return WatchCall::Start(*context, runtime_, request);
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* WorldService::ReadGeometry(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return new ReadGeometryCall(context, runtime_, request);
}

grpc::ServerReadReactor<grpc::ByteBuffer>* WorldService::WriteGeometry(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return WriteGeometryCall::Start(std::make_shared<WriteGeometryCall>(context, runtime_, response));
}

grpc::ServerWriteReactor<grpc::ByteBuffer>* WorldService::ExportWorld(
    grpc::CallbackServerContext* context, const grpc::ByteBuffer* request) {
  return new ExportWorldCall(context, runtime_, request);
}

}  // namespace cwm::server
