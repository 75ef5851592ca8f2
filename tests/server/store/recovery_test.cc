// A restart after a loss: what is not made again, what is dropped, and how long allowances last.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "server/core/error.h"
#include "server/store/replay.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/many_shapes.h"
#include "tests/server/store/recorded_world.h"
#include "tests/server/store/store_wrapper.h"

namespace cwm::server {
namespace {

using collision::Revision;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

Replayed Recovered(Store& store, const ReplayOptions& options = {}) {
  auto replayed = Replay(store, options);
  EXPECT_TRUE(replayed.ok()) << replayed.status();
  return replayed.ok() ? *std::move(replayed) : Replayed();
}

std::string PutNumbered(World& world) {
  std::string name;
  const auto make = [&](const SnapshotPtr&) {
    name = world.ReserveName("object");
    return std::vector<collision::Change>{Put(name)};
  };
  EXPECT_TRUE(world.Update(make, {}).ok());
  return name;
}

void FoldAll(const std::string& uid, Store& store) {
  Compaction compaction(uid, store.last_sequence(), {});
  while (!compaction.done()) {
    const absl::Status status = compaction.Step(store);
    ASSERT_TRUE(status.ok()) << status;
  }
}

TEST(Recovery, TheStoreIsToldWhenTheSkipsAreAppended) {
  for (const LossyStore::Loss loss : {LossyStore::Loss{.observed = true, .durable = false},
                                      LossyStore::Loss{.observed = false, .durable = true}}) {
    MemoryStore store;
    LossyStore empty(store, loss);
    Recovered(empty);
    EXPECT_EQ(empty.recovered_at(), 0) << "there is no world";
    RecordingJournal journal(store);
    const auto first = MakeRecordedWorld("v", "uid-1", journal);
    const auto second = MakeRecordedWorld("w", "uid-2", journal);
    PutNumbered(*first);
    PutNumbered(*second);
    LossyStore lossy(store, loss);
    Recovered(lossy);
    EXPECT_EQ(lossy.recovered_at(), 4) << "behind one record of each world";
    Recovered(lossy);
    EXPECT_EQ(store.last_sequence(), 4) << "the loss is told once";
  }
}

TEST(Recovery, ASoundStoreIsNotTold) {
  MemoryStore store;
  LossyStore sound(store, {});
  Recovered(sound);
  EXPECT_EQ(sound.recovered_at(), std::nullopt);
}

TEST(Recovery, AfterALossOfAcknowledgedRecordsNoRevisionAndNoNameIsGivenAgain) {
  for (const bool is_folded : {false, true}) {
    MemoryStore store;
    RecordingJournal journal(store);
    const auto live = MakeRecordedWorld("w", "uid", journal);
    PutNumbered(*live);
    EXPECT_EQ(PutNumbered(*live), "object_2");
    LossyStore lossy(store, {.observed = true, .durable = true});
    const Revision latest{2 + kRevisionsLostWithBackup};
    const auto expect_no_past = [&](const WorldImage& image) {
      EXPECT_EQ(image.base->revision(), latest);
      EXPECT_EQ(image.oldest_watch, latest);
      EXPECT_THAT(image.earlier, IsEmpty());
      EXPECT_EQ(image.steps.size(), 0u);
      EXPECT_EQ(image.last_numbers.at("object"), 2 + kNamesLostWithBackup);
      EXPECT_THAT(NamesIn(*image.base), ElementsAre("object_1", "object_2"));
    };
    expect_no_past(Recovered(lossy).worlds.front());
    store::v1::Record skip;
    ASSERT_TRUE(skip.ParseFromString(store.Follow("", 2, 1)->front().payload));
    EXPECT_EQ(skip.write().skipped_revisions(), kRevisionsLostWithBackup - 1);
    if (is_folded) FoldAll("uid", store);
    Replayed again = Recovered(store);
    expect_no_past(again.worlds.front());
    const auto restored = Restore(std::move(again.worlds.front()), journal);
    EXPECT_EQ(PutNumbered(*restored), "object_1000003");
    EXPECT_EQ(restored->Snapshot()->revision().value, latest.value + 1);
    ExpectSameWorld(*restored, *Restore(std::move(Recovered(store).worlds.front()), journal));
  }
}

TEST(Recovery, ARecordSaysHowManyRevisionsItSkips) {
  store::v1::Record first;
  first.set_world_uid("uid");
  first.set_created_name("w");
  first.set_revision(8);
  first.mutable_write()->set_makes_revision(true);
  first.mutable_write()->set_skipped_revisions(7);
  WorldFold fold{Retention()};
  ASSERT_TRUE(fold.Apply(first).ok());
  store::v1::Record next = first;
  next.clear_created_name();
  const auto fault = [&](std::int64_t revision, std::int64_t skipped, bool makes_revision) {
    next.set_revision(revision);
    next.mutable_write()->set_skipped_revisions(skipped);
    next.mutable_write()->set_makes_revision(makes_revision);
    WorldFold copy = fold;
    return std::string(copy.Apply(next).status().message());
  };
  EXPECT_EQ(fault(1'000'009, 1'000'000, true), "");
  EXPECT_EQ(fault(20, 10, true), "revision: is 20, must be 19");
  EXPECT_THAT(fault(8, -1, true), HasSubstr("write.skipped_revisions: is -1"));
  EXPECT_THAT(fault(8, std::numeric_limits<std::int64_t>::max(), true),
              HasSubstr("write.skipped_revisions"));
  EXPECT_THAT(fault(8, 1, false), HasSubstr("write.makes_revision: must be true"));
}

// A world in which the contact of two objects is allowed for an hour.
std::shared_ptr<World> WorldWithAllowance(Journal& journal) {
  auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> changes = {
      Put("a"),
      {collision::AllowCollision{.pair = {{"a"}, {"b"}},
                                 .expires = collision::ExpiryAfter(std::chrono::hours(1))},
       std::nullopt}};
  EXPECT_TRUE(live->Apply(changes, {}).ok());
  return live;
}

SnapshotPtr NewestOf(const WorldImage& image) {
  return image.steps.empty() ? image.base : image.steps.back().next;
}

TEST(Recovery, AClockThatWasSetBackLengthensNoAllowance) {
  for (const bool is_folded : {false, true}) {
    MemoryStore store;
    RecordingJournal journal(store);
    WorldWithAllowance(journal);
    if (is_folded) FoldAll("uid", store);
    ClockPair now;
    now.wall = collision::WallTime(std::chrono::hours(1));  // no battery
    const Replayed replayed = Recovered(store, {.now = now});
    const SnapshotPtr newest = NewestOf(replayed.worlds.front());
    ASSERT_EQ(newest->pair_rules().size(), 1u);
    const auto left = (*newest->pair_rules().begin()).expires->due - now.steady;
    EXPECT_LE(left, std::chrono::hours(1));
    EXPECT_GT(left, std::chrono::minutes(59));
    ASSERT_EQ(replayed.warnings.size(), 1u);
    EXPECT_THAT(replayed.warnings.front(), HasSubstr("behind the newest record"));
  }
}

TEST(Recovery, AClockThatGoesOnWarnsOfNothing) {
  MemoryStore store;
  RecordingJournal journal(store);
  WorldWithAllowance(journal);
  ClockPair now;
  now.wall += std::chrono::minutes(20);
  const Replayed replayed = Recovered(store, {.now = now});
  EXPECT_THAT(replayed.warnings, IsEmpty());
  const SnapshotPtr newest = NewestOf(replayed.worlds.front());
  const auto left = (*newest->pair_rules().begin()).expires->due - now.steady;
  EXPECT_LE(left, std::chrono::minutes(40));
  EXPECT_GT(left, std::chrono::minutes(39));
}

TEST(Recovery, AnAllowanceThatEndedMeanwhileIsDueAtOnce) {
  MemoryStore store;
  RecordingJournal journal(store);
  WorldWithAllowance(journal);
  ClockPair now;
  now.wall += std::chrono::hours(2);
  Replayed replayed = Recovered(store, {.now = now});
  const auto restored = Restore(std::move(replayed.worlds.front()), journal);
  EXPECT_EQ(restored->Snapshot()->pair_rules().size(), 1u);
  ASSERT_TRUE(restored->ExpireRules(now.steady).ok());
  EXPECT_EQ(restored->Snapshot()->pair_rules().size(), 0u);
  EXPECT_EQ(restored->Snapshot()->revision(), Revision{2}) << "watches are told";
}

// A store of one world: "small" and "large", a mesh in a blob, and the robot "arm" with "held" in
// its hand.
struct KeptWorld {
  explicit KeptWorld(Durability durability) {
    HybridModel model;
    model.surfaces.push_back(
        {.surface = {.mesh = ModelSource(9).AnyMesh(kSidesOfBlob), .watertight = true}});
    mesh_hash = HashOf(model.surfaces[0].surface.mesh);
    const auto geometry = collision::Prepare(std::make_shared<const HybridModel>(model));
    const auto arm = KeptArm(journal);
    files_hash = arm->files_hash;
    const std::vector<collision::Change> changes = {
        Put("small"),
        {collision::PutObject{.name = "large", .geometry = geometry, .supported_by = {}},
         std::nullopt},
        {collision::testing::PutArm("arm", arm), std::nullopt},
        Put("held", 0.3),
        {collision::AttachObject{.name = "held", .robot = "arm", .link = "tip"}, std::nullopt}};
    EXPECT_TRUE(
        store.PutBlob(mesh_hash, EncodeMesh(*model.surfaces[0].surface.mesh), durability).ok());
    const auto live = MakeRecordedWorld("w", "uid", journal);
    const auto make = [&](const SnapshotPtr&) { return changes; };
    const auto written = live->Update(make, {}, {.durability = durability});
    EXPECT_TRUE(written.ok()) << written.status();
    const std::vector<collision::Change> move = {Move("large", 1)};
    EXPECT_TRUE(live->Apply(move, {}).ok());
  }

  std::shared_ptr<MemoryDisk> disk = std::make_shared<MemoryDisk>();
  MemoryStore store{disk};
  RecordingJournal journal{store};
  std::string mesh_hash, files_hash;
};

std::string DamageOf(Store& store) {
  const absl::Status status = Replay(store, {}).status();
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED") << status;
  return std::string(status.message());
}

TEST(Recovery, AnObservedBlobIsMissedAfterALossOnly) {
  KeptWorld kept(Durability::kObserved);
  kept.disk->blobs.erase(kept.mesh_hash);
  EXPECT_THAT(DamageOf(kept.store), HasSubstr("object 'large'"));
  for (const bool durable : {false, true}) {
    MemoryStore copy(std::make_shared<MemoryDisk>(*kept.disk));
    LossyStore lossy(copy, {.observed = !durable, .durable = durable});
    const Replayed replayed = Recovered(lossy);
    EXPECT_THAT(NamesIn(*replayed.worlds.front().base), ElementsAre("held", "small"));
    EXPECT_THAT(replayed.warnings, ElementsAre(HasSubstr("object 'large' is gone")));
  }
}

TEST(Recovery, ADurableBlobThatIsMissingOrDamagedIsDroppedIfTheLossIsAccepted) {
  for (const bool is_missing : {false, true}) {
    KeptWorld kept(Durability::kDurable);
    if (is_missing) {
      kept.disk->blobs.erase(kept.mesh_hash);
    } else {
      kept.disk->blobs.at(kept.mesh_hash).front() ^= 1;
    }
    LossyStore after_backup(kept.store, {.observed = true, .durable = true});
    EXPECT_THAT(DamageOf(after_backup), HasSubstr("--store-accept-loss")) << "nobody has accepted";
    EXPECT_EQ(after_backup.recovered_at(), std::nullopt);
    const Replayed replayed = Recovered(kept.store, {.accept_loss = true});
    const Revision latest{2 + kRevisionsLostAtMost};
    EXPECT_EQ(replayed.worlds.front().base->revision(), latest);
    EXPECT_THAT(NamesIn(*replayed.worlds.front().base), ElementsAre("held", "small"));
    EXPECT_THAT(replayed.warnings, ElementsAre(HasSubstr("world 'w': object 'large' is gone")));
    const Replayed again = Recovered(kept.store);
    EXPECT_THAT(again.warnings, IsEmpty()) << "it is told once";
    EXPECT_EQ(again.worlds.front().base->revision(), latest);
    EXPECT_EQ(again.worlds.front().oldest_watch, latest);
  }
}

TEST(Recovery, ARobotWhoseFilesAreLostIsDroppedIfTheLossIsAccepted) {
  KeptWorld kept(Durability::kDurable);
  kept.disk->blobs.erase(kept.files_hash);
  EXPECT_THAT(DamageOf(kept.store), ::testing::AllOf(HasSubstr("world 'w' (uid): robot 'arm'"),
                                                     HasSubstr("--store-accept-loss")));
  Replayed replayed = Recovered(kept.store, {.accept_loss = true});
  EXPECT_THAT(replayed.warnings, ElementsAre(HasSubstr("world 'w': robot 'arm' is gone")));
  const SnapshotPtr base = replayed.worlds.front().base;
  EXPECT_EQ(base->FindRobot("arm"), nullptr);
  const auto held = base->Find("held");
  ASSERT_NE(held, nullptr);
  EXPECT_EQ(held->attachment, nullptr) << "there is nothing that holds it";
  EXPECT_DOUBLE_EQ(held->X_WO.translation().x(), 0.3) << "it stays where it was";

  const auto first = Restore(std::move(replayed.worlds.front()), kept.journal);
  ExpectSameWorld(*first, *Restore(std::move(Recovered(kept.store).worlds.front()), kept.journal));
  // The lost files are not needed any more.
  FoldAll("uid", kept.store);
  ExpectSameWorld(*first, *Restore(std::move(Recovered(kept.store).worlds.front()), kept.journal));
}

TEST(Recovery, TheLogBeforeALossIsFoldedWithTheRecordOfTheLoss) {
  KeptWorld kept(Durability::kDurable);
  kept.disk->blobs.erase(kept.files_hash);
  Recovered(kept.store, {.accept_loss = true});
  Compactor compactor({}, {.max_records = 1});
  const auto records = kept.store.Follow("uid", 0, 1 << 30);
  ASSERT_EQ(records->size(), 3u);
  const auto now = std::chrono::system_clock::now();
  for (const StoredRecord& record : *records) {
    compactor.Add({.world_uid = "uid",
                   .sequence = record.sequence,
                   .when_ns = NanosecondsOf(now),
                   .changes = 1,
                   .bytes = static_cast<std::int64_t>(record.payload.size()),
                   .drops_past = record.sequence == 3});
  }
  while (compactor.IsDue(now)) {
    const absl::Status status = compactor.Step(kept.store, now);
    ASSERT_TRUE(status.ok()) << status;
  }
  EXPECT_EQ(kept.store.stats().record_count, 0);
  EXPECT_THAT(NamesIn(*Recovered(kept.store).worlds.front().base),
              UnorderedElementsAre("held", "large", "small"));
}

}  // namespace
}  // namespace cwm::server
