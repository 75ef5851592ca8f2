#include "server/rpc/robot_service.h"

#include <memory>

#include "proto/transfer/sha256.h"
#include "server/core/load_robot.h"
#include "server/rpc/at_revision.h"
#include "server/rpc/call.h"
#include "server/rpc/load_robot_call.h"
#include "server/rpc/robot_pages.h"
#include "server/rpc/robot_states_call.h"
#include "server/rpc/start_query.h"
#include "server/rpc/unary_methods.h"
#include "server/wire/objects.h"
#include "server/wire/queries.h"
#include "server/wire/robots.h"

namespace cwm::server {
namespace {

WriteOptions WriteOptionsOf(v1::DeleteRobotRequest request) {
  WriteOptions options;
  if (request.has_expected_revision()) {
    options.expected_revision = collision::Revision{request.expected_revision()};
  }
  options.request_id = request.request_id();
  request.clear_request_id();
  if (!options.request_id.empty()) options.request_digest = Sha256Hex(request.SerializeAsString());
  return options;
}

absl::Status Delete(Application& application, const v1::DeleteRobotRequest& request,
                    v1::DeleteRobotResponse* response) {
  const FieldPath root;
  if (auto status = CheckName(request.name(), root.Field("name")); !status.ok()) return status;
  auto world = application.worlds.Find(request.world(), request.world_uid());
  if (!world.ok()) return world.status();
  auto outcome = RemoveRobot(**world, request.name(), WriteOptionsOf(request));
  if (!outcome.ok()) return outcome.status();
  response->set_world_uid((*world)->uid());
  response->set_revision(outcome->revision.value);
  return absl::OkStatus();
}

absl::Status GetLinks(const Runtime& runtime, const v1::GetRobotLinksRequest& request,
                      const CallContext& call, v1::GetRobotLinksResponse* response) {
  const FieldPath root;
  if (auto status = CheckName(request.name(), root.Field("name")); !status.ok()) return status;
  const auto rule = RevisionRuleFromProto(request.at_revision(), root.Field("at_revision"));
  if (!rule.ok()) return rule.status();
  const auto at = FindWorldAt(runtime, request.world(), request.world_uid(), *rule, call);
  if (!at.ok()) return at.status();
  const collision::WorldRobotPtr robot = at->snapshot->FindRobot(request.name());
  if (robot == nullptr) return UnknownRobot(request.name());
  response->set_world_uid(at->world->uid());
  response->set_revision(at->snapshot->revision().value);
  SetLinks(*robot, request.with_shapes() ? LinkShapes::kAll : LinkShapes::kNone,
           runtime.application.geometry, response);
  return absl::OkStatus();
}

}  // namespace

grpc::ServerReadReactor<grpc::ByteBuffer>* RobotService::LoadRobot(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return LoadRobotCall::Start(std::make_shared<LoadRobotCall>(context, runtime_, response));
}

grpc::ServerReadReactor<grpc::ByteBuffer>* RobotService::StreamRobotStates(
    grpc::CallbackServerContext* context, grpc::ByteBuffer* response) {
  return RobotStatesCall::Start(std::make_shared<RobotStatesCall>(context, runtime_, response));
}

grpc::ServerUnaryReactor* RobotService::ListRobots(grpc::CallbackServerContext* context,
                                                   const grpc::ByteBuffer* request,
                                                   grpc::ByteBuffer* response) {
  return Read<v1::ListRobotsRequest, v1::ListRobotsResponse>(
      context, runtime_, request, response,
      [this](const v1::ListRobotsRequest& parsed, const CallContext& call,
             v1::ListRobotsResponse* reply) { return ListPage(runtime_, parsed, call, reply); });
}

grpc::ServerUnaryReactor* RobotService::GetRobotLinks(grpc::CallbackServerContext* context,
                                                      const grpc::ByteBuffer* request,
                                                      grpc::ByteBuffer* response) {
  return Read<v1::GetRobotLinksRequest, v1::GetRobotLinksResponse>(
      context, runtime_, request, response,
      [this](const v1::GetRobotLinksRequest& parsed, const CallContext& call,
             v1::GetRobotLinksResponse* reply) { return GetLinks(runtime_, parsed, call, reply); });
}

grpc::ServerUnaryReactor* RobotService::GetLinkPoses(grpc::CallbackServerContext* context,
                                                     const grpc::ByteBuffer* request,
                                                     grpc::ByteBuffer* response) {
  return StartQuery<v1::GetLinkPosesRequest, v1::GetLinkPosesResponse>(context, runtime_, request,
                                                                       response);
}

grpc::ServerUnaryReactor* RobotService::DeleteRobot(grpc::CallbackServerContext* context,
                                                    const grpc::ByteBuffer* request,
                                                    grpc::ByteBuffer* response) {
  return Write<v1::DeleteRobotRequest, v1::DeleteRobotResponse>(
      context, runtime_, request, response,
      [this](const v1::DeleteRobotRequest& parsed, const CallContext&,
             v1::DeleteRobotResponse* reply) {
        return Delete(runtime_.application, parsed, reply);
      });
}

}  // namespace cwm::server
