// Calls that read: small requests with large answers, and clients that do not read them.
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
namespace {

constexpr int kManyObjects = 10'000;

bool MakeManyObjects(Target& target, int) { return PutBoxes(target.server, "w", kManyObjects); }

bool MakeOneTorus(Target& target, int) {
  return StoreTori(target, 1, kLargeAround, kLargeAcross) &&
         PutMesh(target.server, "w", target.hashes[0]);
}

// A call of that request whose answer is not read.
template <class Request>
SendCopy Unread(std::string method, Request request) {
  CallPlan plan = UnaryPlan(std::move(method), request);
  plan.reads = false;
  return [plan](const Target& target, int, Sent& sent) { target.Hold(plan, sent); };
}

SendCopy UnreadExport(v1::ExportFormat format) {
  v1::ExportWorldRequest request;
  request.set_world("w");
  request.set_format(format);
  return Unread("cwm.v1.WorldService/ExportWorld", request);
}

SendCopy UnreadList() {
  v1::ListObjectsRequest request;
  request.set_world("w");
  request.set_view(v1::OBJECT_VIEW_FULL);
  request.set_page_size(10'000);
  return Unread("cwm.v1.WorldService/ListObjects", request);
}

// Puts an object whose message is nearly a mebibyte.
bool MakeLargeObject(Target& target, int) {
  v1::ApplyChangesRequest request;
  request.set_world("w");
  v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
  object->set_name("large");
  for (int i = 0; i < 4'000; ++i) {
    v1::ShapePart* part = object->add_shapes();
    part->mutable_x_object_shape()->set_tx_m(0.001 * i);
    part->mutable_x_object_shape()->set_ty_m(0.5);
    part->mutable_x_object_shape()->set_qw(1);
    part->mutable_cylinder()->set_radius_m(0.1);
    part->mutable_cylinder()->set_length_m(0.1);
  }
  return Apply(target.server, request);
}

void UnreadObjects(const Target& target, int, Sent& sent) {
  v1::GetObjectRequest request;
  request.set_world("w");
  request.set_name("large");
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/GetObject", request);
  plan.reads = false;
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 16; ++i) target.HoldOver(channel, plan, sent);
}

void ReadSurface(const Target& target, int, Sent& sent) {
  v1::ReadGeometryRequest request;
  request.mutable_object()->set_world("w");
  request.mutable_object()->set_name("torus");
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/ReadGeometry", request);
  plan.reads = false;
  target.Hold(plan, sent);
}

void ReadBlob(const Target& target, int, Sent& sent) {
  v1::ReadGeometryRequest request;
  request.set_hash(target.hashes[0]);
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/ReadGeometry", request);
  plan.reads = false;
  target.Hold(plan, sent);
}

SendCopy UnreadWatch() {
  v1::WatchWorldRequest request;
  request.set_world("w");
  request.set_view(v1::OBJECT_VIEW_FULL);
  return Unread("cwm.v1.WorldService/WatchWorld", request);
}

// Unread watches while the world changes. The first copy makes the changes, whose bytes count as
// its own.
void WatchChanges(const Target& target, int copy, Sent& sent) {
  v1::WatchWorldRequest request;
  request.set_world("w");
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/WatchWorld", request);
  plan.reads = false;
  target.Hold(plan, sent);
  if (copy != 0) return;
  std::vector<CallPlan> changes;
  for (int round = 0; round < 30; ++round) {
    v1::ApplyChangesRequest moves;
    moves.set_world("w");
    for (int i = 0; i < 1'000; ++i) {
      v1::MoveObject* move = moves.add_changes()->mutable_move();
      move->set_name(absl::StrCat("box_", i));
      move->mutable_x_world_object()->set_tx_m(round + 0.5);
      move->mutable_x_world_object()->set_qw(1);
    }
    changes.push_back(UnaryPlan("cwm.v1.WorldService/ApplyChanges", moves));
  }
  target.CallSequentially(changes, 3.0, sent);
}

// Small waits for a revision that never comes, as many as one connection may have.
void WaitInCrowds(const Target& target, int, Sent& sent) {
  v1::GetWorldRequest request;
  request.set_world("w");
  request.mutable_at_revision()->set_at_least(1'000'000'000);
  const CallPlan plan = UnaryPlan("cwm.v1.WorldService/GetWorld", request);
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 200; ++i) target.HoldOver(channel, plan, sent);
}

bool MakeManyWorlds(Target& target, int) {
  for (int i = 0; i < 500; ++i) {
    if (!Apply(target.server, TinySpheres(absl::StrCat("world_", std::string(100, 'n'), i), 1)))
      return false;
  }
  return true;
}

void ListWorlds(const Target& target, int, Sent& sent) {
  CallPlan plan{.method = "cwm.v1.WorldService/ListWorlds", .messages = {""}, .reads = false};
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 32; ++i) target.HoldOver(channel, plan, sent);
}

// A different unknown world, hash and object in each call.
void AskUnknown(const Target& target, int copy, Sent& sent) {
  std::vector<CallPlan> plans;
  for (int i = 0; i < 1'500; ++i) {
    const std::string name = absl::StrCat("unknown_", copy, "_", i);
    v1::GetWorldRequest get;
    get.set_world(name);
    plans.push_back(UnaryPlan("cwm.v1.WorldService/GetWorld", get));
    v1::WatchWorldRequest watch;
    watch.set_world(name);
    plans.push_back(UnaryPlan("cwm.v1.WorldService/WatchWorld", watch));
    v1::ReadGeometryRequest read;
    read.set_hash(name);
    plans.push_back(UnaryPlan("cwm.v1.WorldService/ReadGeometry", read));
    v1::ListScansRequest scans;
    scans.set_world(name);
    plans.push_back(UnaryPlan("cwm.v1.PerceptionService/ListScans", scans));
    v1::DeleteRobotRequest robot;
    robot.set_world(name);
    robot.set_request_id(name);
    plans.push_back(UnaryPlan("cwm.v1.RobotService/DeleteRobot", robot));
  }
  target.CallSequentially(plans, 2.0, sent);
}

void AskServerInfo(const Target& target, int, Sent& sent) {
  const CallPlan plan{
      .method = "cwm.v1.AdminService/GetServerInfo", .messages = {""}, .reads = false};
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 500; ++i) target.HoldOver(channel, plan, sent);
}

void ListPrefix(const Target& target, int, Sent& sent) {
  v1::ListObjectsRequest request;
  request.set_world("w");
  request.set_name_prefix(std::string(15 << 20, 'n'));
  CallPlan plan = UnaryPlan("cwm.v1.WorldService/ListObjects", request);
  target.Hold(plan, sent);
}

}  // namespace

std::vector<HostileRequest> ReadingRequests() {
  std::vector<HostileRequest> requests;
  const std::vector<std::pair<std::string, v1::ExportFormat>> formats = {
      {"scene", v1::EXPORT_FORMAT_MOVEIT_SCENE},
      {"yaml", v1::EXPORT_FORMAT_MOVEIT_YAML},
      {"glb", v1::EXPORT_FORMAT_GLB},
      {"ply", v1::EXPORT_FORMAT_PLY},
      {"urdf", v1::EXPORT_FORMAT_URDF},
      {"sdf", v1::EXPORT_FORMAT_SDF}};
  for (const auto& [name, format] : formats) {
    requests.push_back({.name = "ExportWorld/" + name + "_unread",
                        .copies = 6,
                        .prepare = MakeManyObjects,
                        .send = UnreadExport(format)});
  }
  const std::vector<HostileRequest> others = {
      {.name = "ExportWorld/mesh_glb_unread",
       .copies = 6,
       .prepare = MakeOneTorus,
       .send = UnreadExport(v1::EXPORT_FORMAT_GLB)},
      {.name = "ReadGeometry/surface_unread",
       .copies = 6,
       .prepare = MakeOneTorus,
       .send = ReadSurface},
      {.name = "ReadGeometry/blob_unread", .copies = 6, .prepare = MakeOneTorus, .send = ReadBlob},
      {.name = "ListObjects/full_unread",
       .copies = 8,
       .prepare = MakeManyObjects,
       .send = UnreadList()},
      {.name = "ListObjects/prefix", .copies = 4, .prepare = MakeManyObjects, .send = ListPrefix},
      {.name = "GetObject/large_unread",
       .copies = 4,
       .prepare = MakeLargeObject,
       .send = UnreadObjects},
      {.name = "WatchWorld/unread",
       .copies = 16,
       .prepare = MakeManyObjects,
       .send = UnreadWatch()},
      {.name = "WatchWorld/changes_unread",
       .copies = 16,
       .prepare = MakeManyObjects,
       .send = WatchChanges,
       .has_cpu = false},
      {.name = "GetWorld/at_least", .copies = 1, .prepare = MakeManyObjects, .send = WaitInCrowds},
      {.name = "ListWorlds/unread",
       .copies = 4,
       .prepare = MakeManyWorlds,
       .send = ListWorlds,
       .has_cpu = false},
      {.name = "GetWorld/unknown_names", .copies = 1, .send = AskUnknown, .has_cpu = false},
      {.name = "GetServerInfo/unread", .copies = 2, .send = AskServerInfo, .has_cpu = false},
  };
  requests.insert(requests.end(), others.begin(), others.end());
  return requests;
}

}  // namespace cwm::benchmarks
