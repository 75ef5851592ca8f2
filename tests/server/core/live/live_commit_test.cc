// The changes that a frame may make in a world, and those that it must not.
#include "server/core/live/live_commit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::ObjectKind;
using collision::Owner;
using perception::BodyId;
using perception::TrackChange;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

collision::Change PutSeen(const std::string& name, double x_m) {
  collision::Change change = Put(name, x_m);
  auto& put = std::get<collision::PutObject>(change.what);
  put.kind = ObjectKind::kObject;
  put.owner = Owner::kPerception;
  put.supported_by = "table";
  return change;
}

perception::MoverPiece Piece(double x_m, double edge_m) {
  const Vector3 center(x_m, 0, 0);
  const Vector3 half = Vector3::Constant(edge_m / 2);
  return {.boxes_W = {Aabb(center - half, center + half)}};
}

class LiveCommitTest : public ::testing::Test {
 protected:
  LiveCommitTest() {
    Apply({PutSeen("cup", 0), PutSeen("can", 1), Put("mine", 2)});
    bodies_ = numbers_.TableOf(world_->Snapshot());
  }

  void Apply(const std::vector<collision::Change>& changes) {
    const auto applied = world_->Apply(changes, {});
    EXPECT_TRUE(applied.ok()) << applied.status();
  }
  BodyId IdOf(const std::string& name) const {
    for (const perception::KnownBody& body : bodies_->bodies) {
      if (body.name == name) return body.id;
    }
    return perception::kNoBody;
  }
  TrackChange MoveTo(const std::string& name, double x_m) const {
    return {
        .kind = TrackChange::Kind::kMove, .body = IdOf(name), .X_WB = MakeTranslation(x_m, 0, 0)};
  }
  TrackChange RemoveOf(const std::string& name) const {
    return {.kind = TrackChange::Kind::kRemove, .body = IdOf(name)};
  }
  static TrackChange Movers(std::vector<perception::MoverPiece> pieces) {
    return {.kind = TrackChange::Kind::kMovers, .pieces = std::move(pieces)};
  }
  LiveWritten MustCommit(const std::vector<TrackChange>& changes,
                         const std::string& sensor = "head") {
    auto written =
        Commit(*world_, {.bodies = bodies_, .changes = changes, .sensor = sensor}, movers_);
    EXPECT_TRUE(written.ok()) << written.status();
    return *std::move(written);
  }
  double XOf(const std::string& name) const {
    return world_->Snapshot()->Find(name)->X_WO.translation().x();
  }
  std::int64_t revision() const { return world_->Snapshot()->revision().value; }

  const std::shared_ptr<World> world_ = std::make_shared<World>("w", "uid", Retention{});
  BodyNumbers numbers_;
  std::shared_ptr<const BodyTable> bodies_;
  MoverObjects movers_;
};

TEST_F(LiveCommitTest, WhatAFrameChangesIsOneRevision) {
  const LiveWritten written = MustCommit({MoveTo("cup", 0.5), RemoveOf("can")});
  EXPECT_EQ(written.revision.value, 2);
  EXPECT_THAT(written.changes.moved, ElementsAre("cup"));
  EXPECT_THAT(written.changes.removed, ElementsAre("can"));
  EXPECT_EQ(XOf("cup"), 0.5);
  const collision::WorldObjectPtr cup = world_->Snapshot()->Find("cup");
  EXPECT_EQ(cup->kind, ObjectKind::kObject);
  EXPECT_EQ(cup->owner, Owner::kPerception);
  EXPECT_EQ(cup->supported_by, "table");
  EXPECT_EQ(world_->Snapshot()->Find("can"), nullptr);
  ASSERT_EQ(written.removed.size(), 1U);
  EXPECT_EQ(written.removed[0]->name, "can");
}

TEST_F(LiveCommitTest, AnObjectThatChangedSinceTheFrameIsLeftAsItIs) {
  Apply({Move("cup", 3)});
  const LiveWritten written = MustCommit({MoveTo("cup", 0.5), MoveTo("can", 1.5)});
  EXPECT_THAT(written.changes.moved, ElementsAre("can"));
  EXPECT_EQ(XOf("cup"), 3);
  EXPECT_EQ(XOf("can"), 1.5);
  Apply({Remove("cup"), PutSeen("cup", 7)});  // another object of that name
  EXPECT_THAT(MustCommit({RemoveOf("cup")}).changes.removed, IsEmpty());
  EXPECT_EQ(XOf("cup"), 7);
}

TEST_F(LiveCommitTest, AnObjectOfAUserIsNeverChanged) {
  const LiveWritten written = MustCommit({MoveTo("mine", 0.5), RemoveOf("mine")});
  EXPECT_EQ(written.revision.value, 1);
  EXPECT_EQ(revision(), 1);
  EXPECT_EQ(XOf("mine"), 2);
}

TEST_F(LiveCommitTest, MoversAreObjectsForAsLongAsTheyAreSeen) {
  EXPECT_THAT(MustCommit({Movers({Piece(0, 0.1), Piece(1, 0.1)})}).changes.movers,
              ElementsAre("mover_1", "mover_2"));
  const collision::WorldObjectPtr mover = world_->Snapshot()->Find("mover_1");
  ASSERT_NE(mover, nullptr);
  EXPECT_EQ(mover->kind, ObjectKind::kMover);
  EXPECT_EQ(mover->owner, Owner::kPerception);
  EXPECT_TRUE(mover->bounds_W.isApprox(Aabb(Vector3::Constant(-0.05), Vector3::Constant(0.05))));
  // The same again makes no revision.
  EXPECT_EQ(MustCommit({Movers({Piece(0, 0.1), Piece(1, 0.1)})}).revision.value, 2);
  // Fewer pieces: the last ones are gone.
  MustCommit({Movers({Piece(0.5, 0.2)})});
  EXPECT_EQ(XOf("mover_1"), 0.5);
  EXPECT_EQ(world_->Snapshot()->Find("mover_2"), nullptr);
  MustCommit({Movers({})});
  EXPECT_THAT(NamesIn(*world_->Snapshot()), ElementsAre("can", "cup", "mine"));
}

TEST_F(LiveCommitTest, MoversOfTwoSensorsAndNamesOfAUserAreKeptApart) {
  Apply({Put("mover_2", 5)});
  MustCommit({Movers({Piece(0, 0.1)})}, "left");
  EXPECT_THAT(MustCommit({Movers({Piece(1, 0.1)})}, "right").changes.movers,
              ElementsAre("mover_3"));
  MustCommit({Movers({})}, "left");
  EXPECT_THAT(NamesIn(*world_->Snapshot()),
              ElementsAre("can", "cup", "mine", "mover_2", "mover_3"));
  EXPECT_EQ(XOf("mover_2"), 5);
  EXPECT_EQ(XOf("mover_3"), 1);
  // A user takes the name of a piece that is there: it becomes the user's.
  Apply({Put("mover_3", 9)});
  MustCommit({Movers({Piece(1, 0.2)})}, "right");
  EXPECT_EQ(XOf("mover_3"), 9);
  EXPECT_EQ(XOf("mover_1"), 1);
}

TEST_F(LiveCommitTest, MoversOfBeforeARestartAreRemoved) {
  MustCommit({Movers({Piece(0, 0.1), Piece(1, 0.1)})});
  Apply({Put("mover_9", 5)});
  const auto removed =
      world_->Update([](const SnapshotPtr& latest) { return RemoveMovers(*latest); }, {});
  ASSERT_TRUE(removed.ok());
  EXPECT_THAT(NamesIn(*world_->Snapshot()), ElementsAre("can", "cup", "mine", "mover_9"));
}

TEST(BodyNumbersTest, AnObjectKeepsItsNumberUntilItIsRemoved) {
  World world("w", "uid", Retention{});
  const auto apply = [&](const std::vector<collision::Change>& changes) {
    EXPECT_TRUE(world.Apply(changes, {}).ok());
    return world.Snapshot();
  };
  BodyNumbers numbers;
  const auto first = numbers.TableOf(apply({Put("a"), Put("b", 1)}));
  EXPECT_EQ(numbers.TableOf(world.Snapshot()), first);
  ASSERT_EQ(first->bodies.size(), 2U);
  const auto moved = numbers.TableOf(apply({Move("a", 3)}));
  EXPECT_EQ(moved->bodies[0].id, first->bodies[0].id);
  EXPECT_EQ(moved->bodies[0].X_WB.translation().x(), 3);
  EXPECT_EQ(moved->Find(first->bodies[1].id)->name, "b");
  // Another object of the same name has another number, and the old one is not given at once.
  const auto again = numbers.TableOf(apply({Remove("a"), Put("a")}));
  EXPECT_NE(again->bodies[0].id, first->bodies[0].id);
  EXPECT_NE(again->bodies[0].id, first->bodies[1].id);
  EXPECT_EQ(again->Find(first->bodies[0].id), nullptr);
}

}  // namespace
}  // namespace cwm::server
