// Changes of worlds, and worlds themselves.
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "tests/benchmarks/server/hostile_content.h"
#include "tests/benchmarks/server/hostile_request.h"

namespace cwm::benchmarks {
namespace {

constexpr char kApply[] = "cwm.v1.WorldService/ApplyChanges";
constexpr int kMaxChanges = 65'536;
constexpr int kMaxParts = 4'096;

std::string WorldOf(int copy) { return absl::StrCat("w", copy); }

void PutSpheres(const Target& target, int copy, Sent& sent) {
  const v1::ApplyChangesRequest request = TinySpheres(WorldOf(copy), kMaxChanges);
  sent.content_bytes = static_cast<std::int64_t>(request.ByteSizeLong());
  target.Hold(UnaryPlan(kApply, request), sent);
}

void MoveOne(const Target& target, int copy, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  for (int i = 0; i < kMaxChanges; ++i) {
    v1::MoveObject* move = request.add_changes()->mutable_move();
    move->set_name("box_0");
    move->mutable_x_world_object()->set_tx_m(i % 2);
    move->mutable_x_world_object()->set_qw(1);
  }
  target.Hold(UnaryPlan(kApply, request), sent);
}

bool MakeWorlds(Target& target, int copies) {
  for (int copy = 0; copy < copies; ++copy) {
    if (!PutBoxes(target.server, WorldOf(copy), 200)) return false;
  }
  return true;
}

// Plates with as many holes as allowed, one triangle per hole.
void PutPlates(const Target& target, int copy, Sent& sent) {
  constexpr int kPlates = 16, kHolesAcross = 36;
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  const auto add = [](v1::Polygon* polygon, double x, double y) {
    v1::Vector2* vertex = polygon->add_vertices();
    vertex->set_x(x);
    vertex->set_y(y);
  };
  for (int i = 0; i < kPlates; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name(absl::StrCat("plate_", i));
    v1::Plate* plate = object->add_shapes()->mutable_plate();
    plate->set_thickness_m(0.02);
    const double side = kHolesAcross + 1 + 0.01 * (copy * kPlates + i);
    for (const auto& [x, y] : {std::pair{0.0, 0.0}, {side, 0.0}, {side, side}, {0.0, side}}) {
      add(plate->mutable_outline(), x, y);
    }
    for (int hole = 0; hole < kHolesAcross * kHolesAcross; ++hole) {
      const double x = 0.5 + hole % kHolesAcross, y = 0.5 + hole / kHolesAcross;
      v1::Polygon* polygon = plate->add_holes();
      add(polygon, x, y);
      add(polygon, x + 0.4, y);
      add(polygon, x, y + 0.4);
    }
  }
  sent.content_bytes = static_cast<std::int64_t>(request.ByteSizeLong());
  target.Hold(UnaryPlan(kApply, request), sent);
}

enum class Mention { kMesh, kConvex, kSurface };

// An object that mentions the same stored mesh as often as it may.
SendCopy PutMentions(Mention mention, int count) {
  return [mention, count](const Target& target, int copy, Sent& sent) {
    v1::ApplyChangesRequest request;
    request.set_world(WorldOf(copy));
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("many");
    const std::string& hash = target.hashes[static_cast<std::size_t>(copy)];
    for (int i = 0; i < count; ++i) {
      if (mention == Mention::kMesh) object->add_shapes()->mutable_mesh()->set_hash(hash);
      if (mention == Mention::kConvex) object->add_shapes()->mutable_convex()->set_hash(hash);
      if (mention == Mention::kSurface) object->add_surfaces()->set_hash(hash);
    }
    sent.bytes = target.mesh_bytes;
    target.Hold(UnaryPlan(kApply, request), sent);
  };
}

// Puts and replaces the same object with the same mesh in one list.
void ReplaceByMesh(const Target& target, int copy, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  for (int i = 0; i < kMaxParts; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("torus");
    object->add_shapes()->mutable_mesh()->set_hash(target.hashes[static_cast<std::size_t>(copy)]);
  }
  sent.bytes = target.mesh_bytes;
  target.Hold(UnaryPlan(kApply, request), sent);
}

// Pair rules: as many as a world accepts, repeated.
SendCopy SetRules(bool allows) {
  return [allows](const Target& target, int copy, Sent& sent) {
    constexpr int kMaxRules = 4'096;
    v1::ApplyChangesRequest request;
    request.set_world(WorldOf(copy));
    for (int i = 0; i < kMaxChanges; ++i) {
      v1::NamedPair pair;
      pair.mutable_a()->set_name(absl::StrCat("a", i % kMaxRules));
      pair.mutable_b()->set_name("b");
      v1::Change* change = request.add_changes();
      if (allows) {
        *change->mutable_allow()->mutable_pair() = pair;
        change->mutable_allow()->mutable_expires_after()->set_seconds(60 + i);
      } else {
        *change->mutable_margin()->mutable_pair() = pair;
        change->mutable_margin()->set_margin_m(1e-6 * i);
      }
    }
    target.Hold(UnaryPlan(kApply, request), sent);
  };
}

bool MakeArmWorlds(Target& target, int copies) {
  for (int copy = 0; copy < copies; ++copy) {
    if (!PutBoxes(target.server, WorldOf(copy), 20)) return false;
    if (!LoadArm(target.server, WorldOf(copy), 50)) return false;
  }
  return true;
}

void AttachInTurn(const Target& target, int copy, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  for (int i = 0; i < kMaxChanges; ++i) {
    v1::AttachObject* attach = request.add_changes()->mutable_attach();
    attach->set_name(absl::StrCat("box_", i % 20));
    attach->set_robot("arm");
    attach->set_link(absl::StrCat("a", 1 + i % 50));
  }
  target.Hold(UnaryPlan(kApply, request), sent);
}

void SetStates(const Target& target, int copy, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  for (int i = 0; i < kMaxChanges; ++i) {
    v1::SetRobotState* state = request.add_changes()->mutable_robot_state();
    state->set_name("arm");
    v1::VariableValue* value = state->mutable_joints()->add_values();
    value->set_variable("j1");
    value->set_value(1e-5 * i);
  }
  target.Hold(UnaryPlan(kApply, request), sent);
}

// Many small changes in a row, each with a request id that must be remembered.
void RememberIds(const Target& target, int copy, Sent& sent) {
  std::vector<CallPlan> plans;
  for (int i = 0; i < 4'000; ++i) {
    v1::ApplyChangesRequest request;
    request.set_world(WorldOf(copy));
    request.set_request_id(absl::StrCat("id", copy, "_", i));
    v1::MoveObject* move = request.add_changes()->mutable_move();
    move->set_name("box_0");
    move->mutable_x_world_object()->set_tx_m(0.001 * i);
    move->mutable_x_world_object()->set_qw(1);
    plans.push_back(UnaryPlan(kApply, request));
  }
  target.CallSequentially(plans, 2.0, sent);
}

void MakeAndDelete(const Target& target, int copy, Sent& sent) {
  std::vector<CallPlan> plans;
  for (int i = 0; i < 1'500; ++i) {
    const std::string name = absl::StrCat("made_", copy, "_", i);
    plans.push_back(UnaryPlan(kApply, TinySpheres(name, 1)));
    v1::DeleteWorldRequest remove;
    remove.set_world(name);
    remove.set_request_id(absl::StrCat("gone_", copy, "_", i));
    plans.push_back(UnaryPlan("cwm.v1.WorldService/DeleteWorld", remove));
  }
  target.CallSequentially(plans, 2.0, sent);
}

// Writes to worlds that do not exist: a refused write must leave nothing behind.
void RefusedWrites(const Target& target, int copy, Sent& sent) {
  std::vector<CallPlan> plans;
  for (int i = 0; i < 3'000; ++i) {
    v1::ApplyChangesRequest request;
    request.set_world(absl::StrCat("never_", copy, "_", i));
    request.set_request_id(absl::StrCat("never_", copy, "_", i));
    request.add_changes()->mutable_remove()->set_name("nothing");
    plans.push_back(UnaryPlan(kApply, request));
  }
  target.CallSequentially(plans, 2.0, sent);
}

// A name of 15 MiB of an object that does not exist, which an error may repeat.
void HugeName(const Target& target, int, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world("w0");
  request.add_changes()->mutable_remove()->set_name(std::string(15 << 20, 'n'));
  CallPlan plan = UnaryPlan(kApply, request);
  target.Hold(plan, sent);
}

// 65 536 puts.
void CompressedPuts(const Target& target, int copy, Sent& sent) {
  v1::ApplyChangesRequest request;
  request.set_world(WorldOf(copy));
  for (int i = 0; i < kMaxChanges; ++i) {
    v1::Object* object = request.add_changes()->mutable_put()->mutable_object();
    object->set_name("same");
    for (int part = 0; part < 4; ++part) object->add_shapes()->mutable_sphere()->set_radius_m(1);
  }
  CallPlan plan = UnaryPlan(kApply, request);
  target.Hold(plan, sent);
}

}  // namespace

std::vector<HostileRequest> WorldRequests() {
  const auto large = StoreLargeTori;
  const auto hulls = [](Target& target, int copies) {
    return StoreTori(target, copies, kHullAround, kHullAcross);
  };
  return {
      {.name = "ApplyChanges/tiny_spheres", .copies = 2, .send = PutSpheres},
      {.name = "ApplyChanges/moves", .copies = 2, .prepare = MakeWorlds, .send = MoveOne},
      {.name = "ApplyChanges/plates_of_holes", .copies = 2, .send = PutPlates},
      {.name = "ApplyChanges/mesh_mentions",
       .copies = 1,
       .prepare = large,
       .send = PutMentions(Mention::kMesh, kMaxParts)},
      {.name = "ApplyChanges/hull_mentions",
       .copies = 1,
       .prepare = hulls,
       .send = PutMentions(Mention::kConvex, kMaxParts)},
      {.name = "ApplyChanges/one_hull",
       .copies = 2,
       .prepare = hulls,
       .send = PutMentions(Mention::kConvex, 1)},
      {.name = "ApplyChanges/surface_mentions",
       .copies = 1,
       .prepare = large,
       .send = PutMentions(Mention::kSurface, kMaxParts)},
      {.name = "ApplyChanges/mesh_replaced", .copies = 1, .prepare = large, .send = ReplaceByMesh},
      {.name = "ApplyChanges/allowed_pairs",
       .copies = 2,
       .prepare = MakeWorlds,
       .send = SetRules(true)},
      {.name = "ApplyChanges/margins", .copies = 2, .prepare = MakeWorlds, .send = SetRules(false)},
      {.name = "ApplyChanges/attach", .copies = 2, .prepare = MakeArmWorlds, .send = AttachInTurn},
      {.name = "ApplyChanges/robot_states",
       .copies = 2,
       .prepare = MakeArmWorlds,
       .send = SetStates},
      {.name = "ApplyChanges/request_ids",
       .copies = 1,
       .prepare = MakeWorlds,
       .send = RememberIds,
       .has_cpu = false},
      {.name = "ApplyChanges/huge_name", .copies = 4, .prepare = MakeWorlds, .send = HugeName},
      {.name = "ApplyChanges/puts", .copies = 2, .send = CompressedPuts},
      {.name = "ApplyChanges/refused_worlds", .copies = 1, .send = RefusedWrites, .has_cpu = false},
      {.name = "DeleteWorld/made_anew", .copies = 1, .send = MakeAndDelete, .has_cpu = false},
  };
}

}  // namespace cwm::benchmarks
