#include "tests/fault/calls.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>
#include <vector>

#include "clients/cpp/geometry_transfer.h"
#include "clients/cpp/robot_upload.h"
#include "clients/cpp/world_export.h"
#include "proto/transfer/mesh_bytes.h"
#include "proto/transfer/sha256.h"
#include "tests/fault/messages.h"

namespace cwm::fault {
namespace {

using Kind = Operation::Kind;
using Outcome = Operation::Outcome;

// A cart whose plate slides along x.
constexpr char kCartUrdf[] = R"(<robot name="cart">
<link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
<link name="plate"><collision><geometry><box size="0.2 0.2 0.02"/></geometry></collision></link>
<joint name="slide" type="prismatic"><parent link="base"/><child link="plate"/><axis xyz="1 0 0"/>
<limit lower="-1000" upper="1000"/></joint></robot>
)";

// The server's word, or none: a call whose answer is lost, and an answer that says itself that it
// does not know.
bool IsUnknown(const absl::Status& status, const std::string& reason) {
  if (reason == "STORE_FAILED") return true;
  if (!reason.empty()) return false;
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kDeadlineExceeded:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kInternal:
      return true;
    default:
      return false;
  }
}

void SetError(const absl::Status& status, Operation& operation) {
  const client::ErrorDetails details = client::DetailsOf(status);
  operation.outcome = IsUnknown(status, details.reason) ? Outcome::kUnknown : Outcome::kError;
  operation.reason = details.reason.empty() ? std::string(status.message()) : details.reason;
  const auto actual = details.metadata.find("actual_revision");
  if (operation.reason != "REVISION_MISMATCH" || actual == details.metadata.end()) return;
  std::int64_t revision = 0;
  const std::string& text = actual->second;
  std::from_chars(text.data(), text.data() + text.size(), revision);
  operation.actual_revision = revision;
}

// Fills in the reply of a call, which has a uid and a revision.
template <class Reply>
void SetReply(const absl::StatusOr<Reply>& reply, Operation& operation) {
  operation.return_ns = NowNs();
  if (!reply.ok()) {
    SetError(reply.status(), operation);
    return;
  }
  operation.outcome = Outcome::kOk;
  operation.reason.clear();
  operation.world_uid = reply->world_uid();
  operation.revision = reply->revision();
}

void SendRobot(const client::Connection& connection, Operation& operation) {
  const Change& change = operation.changes.front();
  if (change.kind == Change::Kind::kLoadRobot) {
    v1::LoadRobotHeader header;
    header.set_world(operation.world);
    header.set_world_uid(operation.world_uid);
    header.set_name(change.name);
    header.set_urdf(kCartUrdf);
    header.set_request_id(operation.request_id);
    SetReply(client::LoadRobot(connection, header, {}), operation);
    return;
  }
  v1::DeleteRobotRequest request;
  request.set_world(operation.world);
  request.set_world_uid(operation.world_uid);
  request.set_name(change.name);
  request.set_request_id(operation.request_id);
  SetReply(connection.Call(&v1::RobotService::Stub::DeleteRobot, connection.robots(), request),
           operation);
}

void SendChanges(const client::Connection& connection, Operation& operation) {
  v1::ApplyChangesRequest request;
  request.set_world(operation.world);
  request.set_world_uid(operation.world_uid);
  request.set_request_id(operation.request_id);
  if (operation.expected_revision) request.set_expected_revision(*operation.expected_revision);
  for (const Change& change : operation.changes) *request.add_changes() = ToMessage(change);
  SetReply(connection.Call(&v1::WorldService::Stub::ApplyChanges, connection.worlds(), request),
           operation);
}

// The digest of the messages in their order. The messages have no maps, so their bytes are
// deterministic.
template <class Messages>
std::string DigestOf(const Messages& messages) {
  Sha256 digest;
  for (const auto& message : messages) {
    const std::string bytes = message.SerializeAsString();
    digest.Add(bytes.data(), bytes.size());
  }
  return digest.Hex();
}

void ReadRobots(const client::Connection& connection, Operation& operation) {
  v1::ListRobotsRequest request;
  request.set_world(operation.world);
  request.set_world_uid(operation.world_uid);
  request.mutable_at_revision()->set_exact(operation.revision);
  const auto reply =
      connection.Call(&v1::RobotService::Stub::ListRobots, connection.robots(), request);
  if (!reply.ok()) return;  // no longer kept, or the server is gone
  ModelWorld world;
  for (const v1::Robot& robot : reply->robots()) world.robots[robot.name()] = ToRobot(robot);
  operation.robots_hash = HashOf(world).robots;
  operation.digests["robots"] = DigestOf(reply->robots());
}

void ReadRules(const client::Connection& connection, Operation& operation) {
  v1::GetWorldRequest request;
  request.set_world(operation.world);
  request.mutable_at_revision()->set_exact(operation.revision);
  const auto reply =
      connection.Call(&v1::WorldService::Stub::GetWorld, connection.worlds(), request);
  if (!reply.ok() || reply->world_uid() != operation.world_uid) return;
  ModelWorld world;
  for (const v1::PairRule& rule : reply->pair_rules()) world.rules[KeyOf(rule)] = ToRule(rule);
  operation.rules_hash = HashOf(world).rules;
  operation.digests["rules"] = DigestOf(reply->pair_rules());
}

v1::ListObjectsRequest ObjectsRequest(const Operation& operation) {
  v1::ListObjectsRequest request;
  request.set_world(operation.world);
  request.set_world_uid(operation.world_uid);
  request.set_view(v1::OBJECT_VIEW_FULL);
  request.set_page_size(10'000);
  switch (operation.at) {
    case Operation::At::kLatest:
      request.mutable_at_revision()->set_latest(true);
      break;
    case Operation::At::kAtLeast:
      request.mutable_at_revision()->set_at_least(operation.asked_revision);
      break;
    case Operation::At::kExact:
      request.mutable_at_revision()->set_exact(operation.asked_revision);
      break;
  }
  return request;
}

}  // namespace

std::int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

NumberedMesh MakeMesh(std::int64_t number, int vertex_count) {
  struct {
    std::vector<std::array<double, 3>> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
  } mesh;
  const double height = static_cast<double>(number % 1'000'000) / kStepsPerMetre / 1'024;
  for (int i = 0; i < vertex_count; ++i) {
    const auto at = static_cast<std::uint32_t>(i);
    const int row = i / 2;
    const int side = i % 2;
    mesh.vertices.push_back({0.001 * row, 0.1 * side, height});
    if (at >= 2) mesh.triangles.push_back({at - 2, at - 1, at});
  }
  std::string bytes = EncodeMesh(mesh);
  std::string geometry = "mesh:" + Sha256Hex(bytes);
  return {.geometry = std::move(geometry), .bytes = std::move(bytes)};
}

bool UploadMesh(const client::Connection& connection, const NumberedMesh& mesh) {
  return client::WriteGeometry(connection, {.bytes = mesh.bytes}).ok();
}

void Send(const client::Connection& connection, Operation& operation) {
  operation.invoke_ns = NowNs();
  if (operation.kind == Kind::kDelete) {
    v1::DeleteWorldRequest request;
    request.set_world(operation.world);
    request.set_world_uid(operation.world_uid);
    request.set_request_id(operation.request_id);
    SetReply(connection.Call(&v1::WorldService::Stub::DeleteWorld, connection.worlds(), request),
             operation);
  } else if (operation.changes.front().kind == Change::Kind::kLoadRobot ||
             operation.changes.front().kind == Change::Kind::kDeleteRobot) {
    SendRobot(connection, operation);
  } else {
    SendChanges(connection, operation);
  }
}

void Read(const client::Connection& connection, Operation& operation) {
  operation.kind = Kind::kRead;
  operation.invoke_ns = NowNs();
  const auto reply = connection.Call(&v1::WorldService::Stub::ListObjects, connection.worlds(),
                                     ObjectsRequest(operation));
  SetReply(reply, operation);
  if (!reply.ok()) return;
  ModelWorld world;
  for (const v1::Object& object : reply->objects()) world.objects[object.name()] = ToObject(object);
  operation.objects_hash = HashOf(world).objects;
  operation.digests["objects"] = DigestOf(reply->objects());
  ReadRobots(connection, operation);
  ReadRules(connection, operation);
}

bool ReadFiles(const client::Connection& connection, Operation& operation, std::string& error) {
  for (const auto& [what, format] : {std::pair{"glb", v1::EXPORT_FORMAT_GLB},
                                     std::pair{"scene", v1::EXPORT_FORMAT_MOVEIT_SCENE}}) {
    v1::ExportWorldRequest request;
    request.set_world(operation.world);
    request.set_world_uid(operation.world_uid);
    request.set_format(format);
    request.mutable_at_revision()->set_exact(operation.revision);
    const auto files = client::ExportWorld(connection, request);
    if (!files.ok()) {
      error = "export as " + std::string(what) + ": " + files.status().ToString();
      return false;
    }
    operation.digests[what] = Sha256Hex(files->bytes);
  }
  Operation exact = operation;
  exact.at = Operation::At::kExact;
  exact.asked_revision = operation.revision;
  const auto objects = connection.Call(&v1::WorldService::Stub::ListObjects, connection.worlds(),
                                       ObjectsRequest(exact));
  if (!objects.ok()) {
    error = "objects: " + objects.status().ToString();
    return false;
  }
  for (const v1::Object& object : objects->objects()) {
    for (const v1::ShapePart& part : object.shapes()) {
      if (!part.has_mesh()) continue;
      // Compares the bytes with the hash.
      const auto blob = client::ReadGeometry(connection, part.mesh().hash());
      if (blob.ok()) continue;
      error = "mesh of " + object.name() + ": " + blob.status().ToString();
      return false;
    }
  }
  return true;
}

void Follow(const client::Connection& connection, grpc::ClientContext& context, Watch& watch,
            const std::function<bool(const Watch&)>& goes_on) {
  v1::WatchWorldRequest request;
  request.set_world(watch.world);
  request.set_world_uid(watch.world_uid);
  request.set_view(v1::OBJECT_VIEW_FULL);
  request.set_mode(watch.is_lossless ? v1::WATCH_MODE_LOSSLESS : v1::WATCH_MODE_COALESCED);
  if (watch.from_revision) request.set_from_revision(*watch.from_revision);
  watch.invoke_ns = NowNs();
  const auto reader = connection.worlds().WatchWorld(&context, request);
  v1::WatchWorldResponse response;
  while (reader->Read(&response)) {
    watch.messages.push_back(ToWatchMessage(response, NowNs()));
    if (!goes_on(watch)) context.TryCancel();
  }
  const grpc::Status status = reader->Finish();
  if (!status.ok()) {
    watch.end_reason = client::DetailsOf(client::StatusFromGrpc(status)).reason;
  }
}

std::int64_t ReachedBy(const Watch& watch) {
  for (auto message = watch.messages.rbegin(); message != watch.messages.rend(); ++message) {
    if (!message->more) return message->revision;
  }
  return watch.from_revision.value_or(0);
}

}  // namespace cwm::fault
