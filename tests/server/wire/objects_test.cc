#include "server/wire/objects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "server/wire/watch_events.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

class WireObject : public ::testing::Test {
 protected:
  WireObject() {
    v1::Object* object = changes_.Add()->mutable_put()->mutable_object();
    object->set_name("crate");
    object->mutable_x_world_object()->set_tx_m(1);
    object->mutable_x_world_object()->set_qw(1);
    object->add_shapes()->mutable_box()->set_size_x_m(0.2);
    object->mutable_shapes(0)->mutable_box()->set_size_y_m(0.3);
    object->mutable_shapes(0)->mutable_box()->set_size_z_m(0.4);
    object->set_margin_m(0.01);
    object->set_supported_by("table");
  }

  absl::StatusOr<std::vector<collision::Change>> Convert() {
    return ChangesFromProto(changes_, Limits{}, store_, {});
  }
  v1::Object& object() { return *changes_.Mutable(0)->mutable_put()->mutable_object(); }

  GeometryStore store_{kStoreBytes};
  google::protobuf::RepeatedPtrField<v1::Change> changes_;
};

TEST_F(WireObject, APutKeepsWhatCounts) {
  changes_.Mutable(0)->set_expected_object_revision(5);
  const auto changes = Convert();
  ASSERT_TRUE(changes.ok()) << changes.status();
  EXPECT_EQ((*changes)[0].expected_object_revision, collision::Revision{5});
  const auto& put = std::get<collision::PutObject>((*changes)[0].what);
  EXPECT_EQ(put.name, "crate");
  EXPECT_EQ(put.kind, collision::ObjectKind::kUser);
  EXPECT_EQ(put.owner, collision::Owner::kUser);
  EXPECT_EQ(put.margin_m, 0.01);
  EXPECT_EQ(put.supported_by, "table");
  EXPECT_EQ(put.X_WO.translation(), Vector3(1, 0, 0));
  EXPECT_EQ(put.geometry->model->shapes[0].shape, Shape(Box{{0.2, 0.3, 0.4}}));
}

TEST_F(WireObject, OfAScanThatNoWorldHoldsHasTheBoundsOfItsModel) {
  HybridModel model;
  model.shapes.push_back({.X_OS = MakeTranslation(0.1, 0, 0), .shape = Box{{0.2, 0.3, 0.4}}});
  collision::WorldObject seen;
  seen.geometry = std::make_shared<const collision::PreparedModel>(collision::PreparedModel{
      .model = std::make_shared<const HybridModel>(std::move(model)), .parts = {}});
  const v1::Object proto = ObjectToProto(seen, View::kShapes, {}, store_);
  ASSERT_TRUE(proto.has_bounds());
  EXPECT_DOUBLE_EQ(proto.bounds().x_object_box().tx_m(), 0.1);
  EXPECT_DOUBLE_EQ(proto.bounds().box().size_z_m(), 0.4);
}

TEST_F(WireObject, BecomesAMessageInEachView) {
  const auto changes = Convert();
  ASSERT_TRUE(changes.ok());
  const auto& put = std::get<collision::PutObject>((*changes)[0].what);
  collision::WorldObject placed;
  placed.name = put.name;
  placed.X_WO = put.X_WO;
  placed.geometry = put.geometry;
  placed.create_revision = {1};
  placed.geometry_revision = {2};
  placed.pose_revision = {3};
  const auto object = collision::Place(std::move(placed));
  const v1::Object basic = ObjectToProto(*object, View::kBasic, {}, store_);
  EXPECT_EQ(basic.shapes_size(), 0);
  EXPECT_EQ(basic.owner(), v1::OWNER_USER);
  EXPECT_EQ(basic.geometry_revision(), 2);
  EXPECT_EQ(basic.pose_revision(), 3);
  EXPECT_FALSE(basic.has_last_observed());
  EXPECT_DOUBLE_EQ(basic.bounds().box().size_z_m(), 0.4);
  EXPECT_FALSE(basic.has_reachable());
  const Observation seen{.last = std::chrono::system_clock::time_point{}, .reachable = false};
  const v1::Object full = ObjectToProto(*object, View::kFull, seen, store_);
  EXPECT_EQ(full.shapes_size(), 1);
  EXPECT_TRUE(full.has_last_observed());
  EXPECT_TRUE(full.has_reachable());
  EXPECT_FALSE(full.reachable());
}

TEST_F(WireObject, FaultsAreNamedWithTheirWholePath) {
  struct Case {
    std::function<void(v1::Object&)> spoil;
    std::string field;
  };
  const std::vector<Case> cases = {
      {[](auto& o) { o.clear_name(); }, "changes[0].put.object.name"},
      {[](auto& o) { o.set_name("two words"); }, "changes[0].put.object.name"},
      {[](auto& o) { o.set_name(std::string(129, 'a')); }, "changes[0].put.object.name"},
      {[](auto& o) { o.mutable_x_world_object()->set_qw(0.5); },
       "changes[0].put.object.x_world_object.qx..qw"},
      {[](auto& o) { o.mutable_x_world_object()->set_ty_m(kNan); },
       "changes[0].put.object.x_world_object.ty_m"},
      {[](auto& o) { o.set_margin_m(-0.1); }, "changes[0].put.object.margin_m"},
      {[](auto& o) { o.set_margin_m(kNan); }, "changes[0].put.object.margin_m"},
      {[](auto& o) { o.clear_shapes(); }, "changes[0].put.object.shapes"},
      {[](auto& o) { o.mutable_shapes(0)->mutable_box()->set_size_x_m(-0.1); },
       "changes[0].put.object.shapes[0].box.size_x_m"},
      {[](auto& o) { o.mutable_shapes(0)->set_role(static_cast<v1::PartRole>(9)); },
       "changes[0].put.object.shapes[0].role"},
      {[](auto& o) { o.set_kind(static_cast<v1::ObjectKind>(99)); }, "changes[0].put.object.kind"},
      {[](auto& o) { o.add_surfaces(); }, "changes[0].put.object.surfaces[0].hash"},
      {[](auto& o) { o.set_supported_by("\x01"); }, "changes[0].put.object.supported_by"},
      {[](auto& o) { o.set_uid(std::string(1 << 20, 'x')); }, "changes[0].put.object"},
  };
  for (const Case& c : cases) {
    const auto before = changes_;
    c.spoil(object());
    EXPECT_EQ(FieldAtFault(Convert().status()), c.field) << Convert().status();
    changes_ = before;
  }
}

TEST_F(WireObject, OtherChangesAreCheckedToo) {
  changes_.Clear();
  EXPECT_EQ(FieldAtFault(Convert().status()), "changes");
  changes_.Add();
  EXPECT_EQ(FieldAtFault(Convert().status()), "changes[0].what");
  changes_.Mutable(0)->mutable_move()->set_name("crate");
  EXPECT_EQ(FieldAtFault(Convert().status()), "changes[0].move.x_world_object");
  changes_.Mutable(0)->mutable_remove();
  EXPECT_EQ(FieldAtFault(Convert().status()), "changes[0].remove.name");
}

// Two snapshots of a world, for events.
class WireEvents : public ::testing::Test {
 protected:
  collision::WorldObject Object() const {
    auto model = std::make_shared<HybridModel>();
    model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}, .fit = {}});
    collision::WorldObject object;
    object.name = "ball";
    object.geometry = collision::Prepare(std::move(model));
    object.create_revision = {1};
    object.geometry_revision = {1};
    object.pose_revision = {1};
    return object;
  }
  v1::ObjectEvent EventOf(collision::WorldObjectPtr before, collision::WorldObjectPtr after) {
    WatchStep step{.kind = WatchStep::Kind::kEvents, .revision = {2}, .snapshot = {}, .deltas = {}};
    step.deltas.push_back({std::move(before), std::move(after)});
    std::size_t next = 0;
    const auto message = EventsPiece(step, {world_, View::kShapes, store_}, &next);
    EXPECT_EQ(next, 1u);
    EXPECT_FALSE(message.events().more());
    EXPECT_EQ(message.revision(), 2);
    EXPECT_EQ(message.world_uid(), "uid");
    return message.events().events(0);
  }

  World world_{"w", "uid", Retention{}};
  GeometryStore store_{kStoreBytes};
};

TEST_F(WireEvents, AMoveIsSmallAndEverythingElseIsAPut) {
  const auto before = collision::Place(Object());
  collision::WorldObject moved = *before;
  moved.X_WO = MakeTranslation(1, 0, 0);
  moved.pose_revision = {2};
  const auto move = EventOf(before, collision::Place(moved));
  EXPECT_EQ(move.move().name(), "ball");
  EXPECT_EQ(move.pose_revision(), 2);
  // A name, a pose and a revision: all that a move needs on the wire.
  EXPECT_LT(move.ByteSizeLong(), 100u);
  collision::WorldObject hidden = moved;
  hidden.state = collision::ObjectState::kOccluded;
  EXPECT_TRUE(EventOf(before, collision::Place(hidden)).has_put());
  collision::WorldObject another = moved;
  another.create_revision = {2};
  EXPECT_TRUE(EventOf(before, collision::Place(another)).has_put());
  EXPECT_TRUE(EventOf(nullptr, before).has_put());
  EXPECT_EQ(EventOf(before, nullptr).remove(), "ball");
}

TEST_F(WireEvents, TheInitialStateComesInPiecesAndSaysWhenItIsDone) {
  std::vector<collision::WorldObjectPtr> objects;
  collision::WorldObject object = Object();
  for (int i = 0; i < 20'000; ++i) {
    object.name = "ball_" + std::to_string(100'000 + i);
    objects.push_back(collision::Place(object));
  }
  const collision::WorldSnapshot snapshot({3}, objects);
  std::size_t next = 0;
  std::size_t received = 0;
  int messages = 0;
  bool done = false;
  while (!done) {
    const auto message = InitialStatePiece(snapshot, {world_, View::kFull, store_}, &next);
    received += message.initial_state().objects_size();
    done = message.initial_state().initial_state_done();
    EXPECT_LT(message.ByteSizeLong(), std::size_t{2} << 20);
    ++messages;
  }
  EXPECT_EQ(received, objects.size());
  EXPECT_GT(messages, 1);
  std::size_t none = 0;
  EXPECT_TRUE(InitialStatePiece(collision::WorldSnapshot(), {world_, View::kFull, store_}, &none)
                  .initial_state()
                  .initial_state_done());
}

}  // namespace
}  // namespace cwm::server
