// Streams of queries: overlays that stay, messages that are read ahead, streams without messages.
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
namespace {

constexpr char kStream[] = "cwm.v1.QueryService/StreamQueries";

bool MakeBoxesForStreams(Target& target, int) { return PutBoxes(target.server, "w", 2'000); }
bool MakeToriForStreams(Target& target, int copies) {
  return StoreLargeTori(target, copies) && PutBoxes(target.server, "w", 10);
}

void AskOneRow(v1::StreamQueriesRequest& request) {
  v1::GetDistancesRequest* query = request.mutable_get_distances();
  query->set_world("w");
  query->mutable_subject()->mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.1);
  query->mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(1, 0));
}

CallPlan OpenStream(const std::vector<v1::StreamQueriesRequest>& requests) {
  CallPlan plan{.method = kStream, .half_closes = false};
  for (const auto& request : requests) plan.messages.push_back(request.SerializeAsString());
  return plan;
}

v1::StreamQueriesRequest StreamedSpheres() {
  v1::StreamQueriesRequest request;
  request.mutable_overlay()->set_world("w");
  *request.mutable_overlay()->mutable_changes() = TinySpheres("w", 20'000).changes();
  AskOneRow(request);
  return request;
}

void HoldSphereOverlay(const Target& target, int, Sent& sent) {
  target.Hold(OpenStream({StreamedSpheres()}), sent);
}

void HoldCompressedOverlay(const Target& target, int, Sent& sent) {
  CallPlan plan = OpenStream({StreamedSpheres()});
  target.Hold(plan, sent);
}

SendCopy HoldMeshOverlay(int mentions) {
  return [mentions](const Target& target, int copy, Sent& sent) {
    v1::StreamQueriesRequest request;
    request.mutable_overlay()->set_world("w");
    for (int i = 0; i < mentions; ++i) {
      v1::Object* object =
          request.mutable_overlay()->add_changes()->mutable_put()->mutable_object();
      object->set_name(absl::StrCat("torus_", i));
      object->add_shapes()->mutable_mesh()->set_hash(target.hashes[static_cast<std::size_t>(copy)]);
    }
    AskOneRow(request);
    sent.bytes = target.mesh_bytes;
    target.Hold(OpenStream({request}), sent);
  };
}

// Several queries of 15 MiB of zeros: one is processed or waits, one is read ahead.
SendCopy ReadAhead(bool waits) {
  return [waits](const Target& target, int, Sent& sent) {
    v1::StreamQueriesRequest request;
    v1::GetDistancesRequest* query = request.mutable_get_distances();
    query->set_world("w");
    if (waits) query->mutable_options()->mutable_at_revision()->set_at_least(1'000'000'000);
    query->mutable_subject()->mutable_points()->set_data(std::string(15 << 20, '\0'));
    CallPlan plan = OpenStream({request, request, request});
    target.Hold(plan, sent);
  };
}

void OpenIdle(const Target& target, int, Sent& sent) {
  const auto channel = target.server.NewChannel();
  for (int i = 0; i < 200; ++i) target.HoldOver(channel, OpenStream({}), sent);
}

// The largest answers, which nobody reads, with queries behind them.
void LeaveUnread(const Target& target, int, Sent& sent) {
  v1::StreamQueriesRequest request;
  v1::GetDistancesRequest* query = request.mutable_get_distances();
  query->set_world("w");
  query->mutable_subject()->mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(0.1);
  query->mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(4'096, 0));
  query->mutable_options()->set_max_results(64);
  CallPlan plan = OpenStream({request, request, request, request});
  plan.reads = false;
  target.Hold(plan, sent);
}

}  // namespace

std::vector<HostileRequest> StreamRequests() {
  return {
      {.name = "StreamQueries/overlay_spheres",
       .copies = 4,
       .prepare = MakeBoxesForStreams,
       .send = HoldSphereOverlay},
      {.name = "StreamQueries/overlay",
       .copies = 4,
       .prepare = MakeBoxesForStreams,
       .send = HoldCompressedOverlay},
      {.name = "StreamQueries/overlay_mesh",
       .copies = 2,
       .prepare = MakeToriForStreams,
       .send = HoldMeshOverlay(1)},
      {.name = "StreamQueries/overlay_mesh_mentions",
       .copies = 1,
       .prepare = MakeToriForStreams,
       .send = HoldMeshOverlay(2'000)},
      {.name = "StreamQueries/read_ahead",
       .copies = 4,
       .prepare = MakeBoxesForStreams,
       .send = ReadAhead(false)},
      {.name = "StreamQueries/at_least",
       .copies = 4,
       .prepare = MakeBoxesForStreams,
       .send = ReadAhead(true)},
      {.name = "StreamQueries/idle", .copies = 1, .send = OpenIdle, .has_cpu = false},
      {.name = "StreamQueries/unread",
       .copies = 4,
       .prepare = MakeBoxesForStreams,
       .send = LeaveUnread},
  };
}

}  // namespace cwm::benchmarks
