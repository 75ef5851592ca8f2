// Queries: many mentions of one mesh, the largest answers, engines that are hard to stop.
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "clients/cpp/row_bytes.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
namespace {

constexpr char kService[] = "cwm.v1.QueryService/";
constexpr int kMaxRows = 65'536;

std::string HashOf(const Target& target, int copy) {
  return target.hashes[static_cast<std::size_t>(copy)];
}

bool MakeBoxes(Target& target, int) { return PutBoxes(target.server, "w", 2'000); }

// Stores large meshes and puts the first into the world.
bool MakeTori(Target& target, int copies) {
  return StoreLargeTori(target, copies) && PutMesh(target.server, "w", target.hashes[0]);
}
bool MakeHullTori(Target& target, int copies) {
  return StoreTori(target, copies, kHullAround, kHullAcross) && PutBoxes(target.server, "w", 200);
}

v1::Subject Mentions(const std::string& hash, int count, bool convex, int rows) {
  v1::Subject subject;
  for (int i = 0; i < count; ++i) {
    v1::PlacedShape* shape = subject.mutable_shapes()->add_shapes();
    if (convex) {
      shape->mutable_convex()->set_hash(hash);
    } else {
      shape->mutable_mesh()->set_hash(hash);
    }
  }
  subject.mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(rows, 0.01));
  return subject;
}

v1::Subject Ball(double radius_m, int rows) {
  v1::Subject subject;
  subject.mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(radius_m);
  subject.mutable_shapes()->mutable_x_world_body()->set_data(PoseBytes(rows, 0));
  return subject;
}

template <class Request>
SendCopy AskMentions(std::string method, int count, bool convex, int rows, v1::Engine engine) {
  return [=](const Target& target, int copy, Sent& sent) {
    Request request;
    request.set_world("w");
    *request.mutable_subject() = Mentions(HashOf(target, copy), count, convex, rows);
    request.mutable_options()->set_engine(engine);
    sent.bytes = target.mesh_bytes;
    target.Hold(UnaryPlan(kService + method, request), sent);
  };
}

template <class Request>
SendCopy SendQuery(std::string method, Request request, bool reads = true) {
  request.set_world("w");
  CallPlan plan = UnaryPlan(kService + method, request);
  plan.reads = reads;
  return [plan](const Target& target, int, Sent& sent) { target.Hold(plan, sent); };
}

v1::GetContactsRequest MostContacts(v1::ResultForm form) {
  v1::GetContactsRequest request;
  const bool columns = form == v1::RESULT_FORM_COLUMNS;
  *request.mutable_subject() = Ball(0.5, columns ? 1'024 : 64);
  v1::QueryOptions* options = request.mutable_options();
  options->set_margin_m(100);
  options->set_max_contacts(1'024);
  options->set_result_form(form);
  return request;
}

v1::GetDistancesRequest MostDistances(v1::ResultForm form) {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = Ball(0.01, form == v1::RESULT_FORM_COLUMNS ? 16'384 : 1'024);
  request.mutable_options()->set_max_results(64);
  request.mutable_options()->set_result_form(form);
  return request;
}

v1::CastRaysRequest MostRays() {
  std::vector<client::RayRow> rays;
  for (int i = 0; i < kMaxRows; ++i) rays.push_back({-2, 0.001 * i, 0, 1, -0.001 * i, 1e-5 * i});
  v1::CastRaysRequest request;
  request.mutable_rays()->set_data(client::RowBytes(rays));
  return request;
}

v1::SamplePointsRequest MostPoints() {
  v1::SamplePointsRequest request;
  request.mutable_points()->set_data(PointBytes(kMaxRows));
  return request;
}

v1::GetDistancesRequest PointsAmongAll() {
  v1::GetDistancesRequest request;
  request.mutable_subject()->mutable_points()->set_data(PointBytes(kMaxRows));
  request.mutable_options()->set_max_results(16);
  return request;
}

v1::CheckCollisionsRequest LongIgnoreList() {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Ball(0.01, 1);
  for (int i = 0; i < kMaxRows; ++i) request.mutable_options()->add_ignore(absl::StrCat("box_", i));
  return request;
}

v1::CheckCollisionsRequest ManyIgnoredPairs() {
  v1::CheckCollisionsRequest request;
  *request.mutable_subject() = Ball(0.01, 1'000);
  for (int i = 0; i < 4'096; ++i) {
    v1::NamedPair* pair = request.mutable_options()->add_ignore_pairs();
    pair->mutable_a()->set_name(absl::StrCat("box_", i));
    pair->mutable_b()->set_name("*");
  }
  return request;
}

v1::GetDistancesRequest SphereOverlay() {
  v1::GetDistancesRequest request;
  *request.mutable_subject() = Ball(0.01, 1);
  *request.mutable_options()->mutable_overlay() = TinySpheres("w", 20'000).changes();
  return request;
}

void MeshOverlay(const Target& target, int copy, Sent& sent) {
  v1::GetDistancesRequest request;
  request.set_world("w");
  *request.mutable_subject() = Ball(0.01, 1);
  for (int i = 0; i < 64; ++i) {
    v1::Object* object = request.mutable_options()->add_overlay()->mutable_put()->mutable_object();
    object->set_name(absl::StrCat("torus_", i));
    object->add_shapes()->mutable_mesh()->set_hash(HashOf(target, copy));
  }
  sent.bytes = target.mesh_bytes;
  target.Hold(UnaryPlan("cwm.v1.QueryService/GetDistances", request), sent);
}

// A query with an overlay object that mentions one hull as often as an object may.
void HullOverlay(const Target& target, int copy, Sent& sent) {
  v1::GetDistancesRequest request;
  request.set_world("w");
  *request.mutable_subject() = Ball(0.01, 1);
  v1::Object* object = request.mutable_options()->add_overlay()->mutable_put()->mutable_object();
  object->set_name("hulls");
  for (int i = 0; i < 4'096; ++i) {
    object->add_shapes()->mutable_convex()->set_hash(HashOf(target, copy));
  }
  sent.bytes = target.mesh_bytes;
  target.Hold(UnaryPlan("cwm.v1.QueryService/GetDistances", request), sent);
}

// A mesh that moves through the mesh of the world, along a path of 2 000 rows.
void LongMotion(const Target& target, int copy, Sent& sent) {
  constexpr int kRows = 2'000;
  v1::CheckMotionsRequest request;
  request.set_world("w");
  *request.mutable_subject() = Mentions(HashOf(target, copy), 1, false, kRows);
  request.add_path_row_counts(kRows);
  sent.bytes = target.mesh_bytes;
  target.Hold(UnaryPlan("cwm.v1.QueryService/CheckMotions", request), sent);
}

// A query with a body of 15 MiB that waits for a revision that never comes.
v1::GetDistancesRequest LargeWait() {
  v1::GetDistancesRequest request;
  request.mutable_options()->mutable_at_revision()->set_at_least(1'000'000'000);
  request.mutable_subject()->mutable_points()->set_data(std::string(15 << 20, '\0'));
  return request;
}

v1::CheckCollisionsRequest ManyShapes() {
  v1::CheckCollisionsRequest request;
  for (int i = 0; i < 1'000; ++i) {
    request.mutable_subject()->mutable_shapes()->add_shapes()->mutable_sphere()->set_radius_m(5);
  }
  request.mutable_subject()->mutable_shapes()->mutable_x_world_body()->set_data(
      PoseBytes(4'096, 0));
  return request;
}

}  // namespace

std::vector<HostileRequest> QueryRequests() {
  const auto exact = v1::ENGINE_AUTO, fcl = v1::ENGINE_FCL, bullet = v1::ENGINE_BULLET;
  return {
      {.name = "CheckCollisions/mesh_mentions",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::CheckCollisionsRequest>("CheckCollisions", 1'000, false, 1, exact)},
      {.name = "CheckCollisions/hull_mentions",
       .copies = 1,
       .prepare = MakeHullTori,
       .send = AskMentions<v1::CheckCollisionsRequest>("CheckCollisions", 1'000, true, 1, exact)},
      {.name = "CheckCollisions/many_shapes",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("CheckCollisions", ManyShapes())},
      {.name = "GetDistances/mesh_mentions",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::GetDistancesRequest>("GetDistances", 256, false, 16, exact)},
      {.name = "GetContacts/mesh_mentions",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::GetContactsRequest>("GetContacts", 64, false, 16, exact)},
      {.name = "CheckMotions/mesh_mentions",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::CheckMotionsRequest>("CheckMotions", 64, false, 16, exact)},
      {.name = "CheckMotions/long_path", .copies = 1, .prepare = MakeTori, .send = LongMotion},
      {.name = "CheckCollisions/fcl_mesh",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::CheckCollisionsRequest>("CheckCollisions", 1, false, 256, fcl)},
      {.name = "GetDistances/fcl_mesh",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::GetDistancesRequest>("GetDistances", 1, false, 256, fcl)},
      {.name = "GetContacts/fcl_mesh",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::GetContactsRequest>("GetContacts", 1, false, 256, fcl)},
      {.name = "CheckCollisions/bullet_mesh",
       .copies = 1,
       .prepare = MakeTori,
       .send = AskMentions<v1::CheckCollisionsRequest>("CheckCollisions", 1, false, 256, bullet)},
      {.name = "GetContacts/most_unread",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("GetContacts", MostContacts(v1::RESULT_FORM_COLUMNS), false)},
      {.name = "GetContacts/most_rows_unread",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("GetContacts", MostContacts(v1::RESULT_FORM_ROWS), false)},
      {.name = "GetDistances/most_unread",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("GetDistances", MostDistances(v1::RESULT_FORM_COLUMNS), false)},
      {.name = "GetDistances/most_rows_unread",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("GetDistances", MostDistances(v1::RESULT_FORM_ROWS), false)},
      {.name = "GetDistances/points",
       .copies = 2,
       .prepare = MakeBoxes,
       .send = SendQuery("GetDistances", PointsAmongAll())},
      {.name = "CastRays/most_at_mesh",
       .copies = 2,
       .prepare = MakeTori,
       .send = SendQuery("CastRays", MostRays())},
      {.name = "SamplePoints/most_in_mesh",
       .copies = 2,
       .prepare = MakeTori,
       .send = SendQuery("SamplePoints", MostPoints())},
      {.name = "CheckCollisions/ignore_65536",
       .copies = 4,
       .prepare = MakeBoxes,
       .send = SendQuery("CheckCollisions", LongIgnoreList())},
      {.name = "CheckCollisions/ignored_pairs",
       .copies = 4,
       .prepare = MakeBoxes,
       .send = SendQuery("CheckCollisions", ManyIgnoredPairs())},
      {.name = "GetDistances/overlay_spheres",
       .copies = 4,
       .prepare = MakeBoxes,
       .send = SendQuery("GetDistances", SphereOverlay())},
      {.name = "GetDistances/overlay_meshes",
       .copies = 1,
       .prepare = MakeTori,
       .send = MeshOverlay},
      {.name = "GetDistances/overlay_hulls",
       .copies = 1,
       .prepare = MakeHullTori,
       .send = HullOverlay},
      {.name = "GetDistances/at_least",
       .copies = 8,
       .prepare = MakeBoxes,
       .send = SendQuery("GetDistances", LargeWait())},
  };
}

}  // namespace cwm::benchmarks
