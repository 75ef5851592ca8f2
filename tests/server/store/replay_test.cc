// A restart: what is replayed from a store is what was there.
#include "server/store/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "server/core/error.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/recorded_world.h"
#include "tests/server/store/store_wrapper.h"
#include "tests/server/store/story.h"

namespace cwm::server {
namespace {

using collision::Revision;
using ::testing::HasSubstr;

Replayed ReplayOf(Store& store, const Retention& retention = {}) {
  auto replayed = Replay(store, {.retention = retention, .threads = 2});
  EXPECT_TRUE(replayed.ok()) << replayed.status();
  return replayed.ok() ? *std::move(replayed) : Replayed();
}

// Retentions under which a story outgrows what is kept.
Retention ShortRetention() {
  Retention retention = KeepOnlyTheLast(20);
  retention.watch_events = 100;
  return retention;
}

TEST(Replay, NoClientCanTellARestoredWorldFromTheOneBefore) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    for (const Retention& retention : {Retention(), ShortRetention()}) {
      MemoryStore store;
      RecordingJournal journal(store);
      const auto live = MakeRecordedWorld("kitchen", "uid-1", journal, retention);
      Story story(journal, seed);
      for (int i = 0; i < 400; ++i) story.WriteTo(*live);
      EXPECT_GT(story.written(), 200);
      EXPECT_GT(story.refused(), 20);
      Replayed replayed = ReplayOf(store, retention);
      ASSERT_EQ(replayed.worlds.size(), 1u);
      EXPECT_TRUE(replayed.warnings.empty());
      const auto restored = Restore(std::move(replayed.worlds.front()), journal, retention);
      ExpectSameWorld(*live, *restored);
      for (const std::string sensor : {"left", "right"}) {
        ASSERT_TRUE(live->SensorPoseOf(sensor) && restored->SensorPoseOf(sensor));
        EXPECT_EQ(live->SensorPoseOf(sensor)->X_WC.matrix(),
                  restored->SensorPoseOf(sensor)->X_WC.matrix());
        EXPECT_EQ(live->SensorPoseOf(sensor)->given, restored->SensorPoseOf(sensor)->given);
      }
      const auto observed = live->observations().NewerThan(0, 1000);
      const auto again = restored->observations().NewerThan(0, 1000);
      ASSERT_EQ(observed.size(), again.size());
      EXPECT_FALSE(observed.empty());
      for (std::size_t i = 0; i < observed.size(); ++i) {
        EXPECT_EQ(observed[i].name, again[i].name) << "in the order in which they were made";
        EXPECT_EQ(observed[i].last, again[i].last);
      }
    }
  }
}

TEST(Replay, TheWorldGoesOnAsIfNothingHadHappened) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("kitchen", "uid-1", journal);
  Story story(journal, 7), same(journal, 7);
  for (int i = 0; i < 150; ++i) story.WriteTo(*live);
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore other(disk);
  RecordingJournal other_journal(other);
  auto restarted = MakeRecordedWorld("kitchen", "uid-1", other_journal);
  Story other_story(other_journal, 7);
  for (int i = 0; i < 150; ++i) {
    other_story.WriteTo(*restarted);
    if (i % 40 != 39) continue;
    Replayed replayed = ReplayOf(other);
    ASSERT_EQ(replayed.worlds.size(), 1u);
    restarted = Restore(std::move(replayed.worlds.front()), other_journal);
  }
  const auto latest = live->Snapshot();
  ASSERT_EQ(latest->revision(), restarted->Snapshot()->revision());
  for (const auto& object : latest->objects()) {
    const auto same_object = restarted->Snapshot()->Find(object->name);
    ASSERT_NE(same_object, nullptr) << object->name;
    EXPECT_EQ(object->Uid(), same_object->Uid());
    EXPECT_EQ(object->pose_revision, same_object->pose_revision);
    EXPECT_EQ(object->geometry_revision, same_object->geometry_revision);
  }
}

TEST(Replay, ARetryGetsTheFirstReply) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")}, move = {Move("a", 2)};
  const WriteOptions first{.request_id = "one", .request_digest = "d"};
  ASSERT_TRUE(live->Apply(put, first).ok());
  ASSERT_TRUE(live->Apply(move, {}).ok());
  const WriteOptions idle{.request_id = "idle", .request_digest = "d"};
  ASSERT_TRUE(live->Apply(move, idle).ok()) << "has no effect, and is remembered all the same";
  const auto restored = Restore(std::move(ReplayOf(store).worlds.front()), journal);
  const auto retry = restored->Apply(put, first);
  ASSERT_TRUE(retry.ok()) << retry.status();
  EXPECT_TRUE(retry->replayed);
  EXPECT_EQ(retry->revision, Revision{1});
  const auto retry_of_idle = restored->Apply(move, idle);
  EXPECT_TRUE(retry_of_idle->replayed);
  EXPECT_EQ(retry_of_idle->revision, Revision{2});
  const auto other = restored->Apply(put, {.request_id = "one", .request_digest = "other"});
  EXPECT_EQ(DetailsOf(other.status()).reason, "REQUEST_ID_REUSED");
}

TEST(Replay, NamesAreNeverGivenTwice) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  std::set<std::string> names;
  const auto put_new = [&](World& world) {
    const auto make = [&](const SnapshotPtr&) {
      const std::string name = world.ReserveName("object");
      EXPECT_TRUE(names.insert(name).second) << name;
      return std::vector<collision::Change>{Put(name)};
    };
    ASSERT_TRUE(world.Update(make, {}).ok());
  };
  put_new(*live);
  put_new(*live);
  const std::vector<collision::Change> remove = {Remove("object_2")};
  ASSERT_TRUE(live->Apply(remove, {}).ok());
  const auto restored = Restore(std::move(ReplayOf(store).worlds.front()), journal);
  put_new(*restored);
  EXPECT_EQ(names, (std::set<std::string>{"object_1", "object_2", "object_3"}));
}

TEST(Replay, EqualGeometryIsPreparedOnceAndSharedAgain) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  for (int i = 0; i < 10; ++i) {
    const std::vector<collision::Change> put = {Put("a" + std::to_string(i), i)};
    ASSERT_TRUE(live->Apply(put, {}).ok());
  }
  const std::vector<collision::Change> move = {Move("a3", 7)};
  ASSERT_TRUE(live->Apply(move, {}).ok());
  Replayed replayed = ReplayOf(store);
  EXPECT_EQ(replayed.geometry_count, 1);
  EXPECT_EQ(replayed.record_count, 11);
  const WorldImage& image = replayed.worlds.front();
  std::set<const collision::PreparedModel*> geometries;
  for (const auto& object : image.steps.back().next->objects()) {
    geometries.insert(object->geometry.get());
  }
  EXPECT_EQ(geometries.size(), 1u);
  const auto& delta = image.steps.back().event->deltas.front();
  EXPECT_EQ(delta.before->geometry, delta.after->geometry);
}

TEST(Replay, ADeletedWorldIsKnownForRetriesOnly) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")};
  ASSERT_TRUE(live->Apply(put, {}).ok());
  ASSERT_TRUE(live->Close({.requested_uid = "uid", .request_id = "r"}).ok());
  const auto next = MakeRecordedWorld("w", "uid-2", journal);
  ASSERT_TRUE(next->Apply(put, {}).ok());
  const Replayed replayed = ReplayOf(store);
  ASSERT_EQ(replayed.worlds.size(), 1u);
  EXPECT_EQ(replayed.worlds.front().uid, "uid-2");
  ASSERT_EQ(replayed.deleted.size(), 1u);
  const DeletedWorldImage& deleted = replayed.deleted.front();
  EXPECT_EQ(deleted.name, "w");
  EXPECT_EQ(deleted.uid, "uid");
  EXPECT_EQ(deleted.revision, Revision{1});
  EXPECT_EQ(deleted.deletion.request_id, "r");
  EXPECT_EQ(deleted.deletion.requested_uid, "uid");

  ClockPair later;
  later.wall += std::chrono::minutes(11);
  const auto afterwards = Replay(store, {.now = later});
  ASSERT_TRUE(afterwards.ok());
  EXPECT_TRUE(afterwards->deleted.empty()) << "request ids are kept for ten minutes";
}

TEST(Replay, RequestsAndEventsExpireInWallTime) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  for (int i = 0; i < 300; ++i) {
    const std::vector<collision::Change> put = {Put("a", i)};
    ASSERT_TRUE(live->Apply(put, {.request_id = std::to_string(i)}).ok());
  }
  ClockPair later;
  later.wall += std::chrono::minutes(6);
  const auto replayed = Replay(store, {.now = later});
  ASSERT_TRUE(replayed.ok());
  const WorldImage& image = replayed->worlds.front();
  EXPECT_TRUE(image.earlier.empty()) << "watches go back five minutes";
  EXPECT_EQ(image.base->revision(), Revision{45});
  EXPECT_EQ(image.steps.size(), 255u) << "256 exact snapshots are kept however old they are";
  EXPECT_EQ(image.requests.size(), 300u);
  const auto age = later.steady - image.requests.front().when;
  EXPECT_GT(age, std::chrono::minutes(6) - std::chrono::seconds(1));
  later.wall += std::chrono::minutes(5);
  const auto much_later = Replay(store, {.now = later});
  EXPECT_TRUE(much_later->worlds.front().requests.empty());
}

TEST(Replay, GeometryOfTheWindowIsLimitedByItsBytes) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  ModelSource source(5);
  for (int i = 0; i < 40; ++i) {
    HybridModel model;
    model.surfaces.push_back({.surface = {.mesh = source.AnyMesh(kSidesOfBlob)}});
    const auto geometry = collision::Prepare(std::make_shared<const HybridModel>(model));
    const std::vector<collision::Change> put = {
        {collision::PutObject{.name = "scan", .geometry = geometry, .supported_by = {}},
         std::nullopt}};
    ASSERT_TRUE(live->Apply(put, {}).ok());
  }
  const std::int64_t bytes = std::int64_t{228} * 2 * kSidesOfBlob;  // of one prepared mesh, about
  const Replayed replayed =
      ReplayOf(store, {.snapshot_bytes = 10 * bytes, .watch_bytes = 10 * bytes});
  EXPECT_LE(replayed.geometry_count, 12);
  EXPECT_GE(replayed.geometry_count, 7);
  EXPECT_EQ(replayed.worlds.front().steps.back().next->revision(), Revision{40});
}

TEST(Replay, AfterAPowerCutEveryWorldSkipsRevisionsForGood) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")};
  ASSERT_TRUE(live->Apply(put, {}).ok());
  LossyStore cut(store, {.observed = true});
  const Replayed replayed = ReplayOf(cut);
  const WorldImage& image = replayed.worlds.front();
  EXPECT_EQ(image.steps.back().next->revision(), Revision{1 + kRevisionsLostAtMost});
  EXPECT_EQ(image.steps.back().event->size(), 0);
  EXPECT_NE(image.steps.back().next->Find("a"), nullptr);
  EXPECT_EQ(store.last_sequence(), 2) << "the skip is a record";
  Replayed again = ReplayOf(store);
  ASSERT_EQ(again.worlds.size(), 1u);
  const auto restored = Restore(std::move(again.worlds.front()), journal);
  EXPECT_EQ(restored->Snapshot()->revision(), Revision{1 + kRevisionsLostAtMost});
  const std::vector<collision::Change> move = {Move("a", 1)};
  const auto moved = restored->Apply(move, {});
  ASSERT_TRUE(moved.ok()) << moved.status();
  EXPECT_EQ(moved->revision, Revision{2 + kRevisionsLostAtMost});
  ExpectSameWorld(*restored, *Restore(std::move(ReplayOf(store).worlds.front()), journal));
}

// A world with one object of large geometry, of the given class, beside another object.
std::string PutLarge(World& world, Durability durability) {
  HybridModel model;
  model.surfaces.push_back(
      {.surface = {.mesh = ModelSource(9).AnyMesh(kSidesOfBlob), .watertight = true}});
  const auto geometry = collision::Prepare(std::make_shared<const HybridModel>(model));
  const std::vector<collision::Change> changes = {
      Put("small"),
      {collision::PutObject{.name = "large", .geometry = geometry, .supported_by = {}},
       std::nullopt}};
  EXPECT_TRUE(world.KeepGeometry({{geometry}}, durability).ok());
  const auto make = [&](const SnapshotPtr&) { return changes; };
  EXPECT_TRUE(world.Update(make, {}, {.durability = durability}).ok());
  return HashOf(model.surfaces[0].surface.mesh);
}

TEST(Replay, AnObservedObjectWhoseGeometryIsMissingIsDroppedAndToldOnce) {
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore store(disk);
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::string hash = PutLarge(*live, Durability::kObserved);
  const std::vector<collision::Change> move = {Move("large", 1)};
  ASSERT_TRUE(live->Apply(move, {}).ok());
  ASSERT_EQ(disk->blobs.erase(hash), 1u);
  LossyStore cut(store, {.observed = true});
  Replayed replayed = ReplayOf(cut);
  ASSERT_EQ(replayed.warnings.size(), 1u);
  EXPECT_THAT(replayed.warnings.front(), HasSubstr("world 'w': object 'large' is gone"));
  const auto restored = Restore(std::move(replayed.worlds.front()), journal);
  EXPECT_EQ(restored->Snapshot()->Find("large"), nullptr);
  EXPECT_NE(restored->Snapshot()->Find("small"), nullptr);
  const Revision latest{2 + kRevisionsLostAtMost};
  EXPECT_EQ(restored->Snapshot()->revision(), latest);
  EXPECT_EQ(restored->oldest_watch(), latest) << "no watch may miss the removal";

  Replayed again = ReplayOf(store);
  EXPECT_TRUE(again.warnings.empty());
  const WorldImage& image = again.worlds.front();
  EXPECT_TRUE(image.steps.empty()) << "older revisions had the object";
  EXPECT_EQ(image.base->revision(), latest) << "nothing else is lost";
}

TEST(Replay, ADurableObjectWhoseGeometryIsMissingIsDamage) {
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore store(disk);
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::string hash = PutLarge(*live, Durability::kDurable);
  disk->blobs.erase(hash);
  const absl::Status status = Replay(store, {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kDataLoss) << status;
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED");
  EXPECT_THAT(std::string(status.message()), HasSubstr("world 'w' (uid): object 'large'"));
}

TEST(Replay, ARobotWhoseFilesAreMissingIsDamage) {
  auto disk = std::make_shared<MemoryDisk>();
  MemoryStore store(disk);
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const auto arm = KeptArm(journal);
  const collision::Change put{collision::testing::PutArm("arm", arm), std::nullopt};
  ASSERT_TRUE(live->Apply({&put, 1}, {}).ok());
  disk->blobs.erase(arm->files_hash);
  const absl::Status status = Replay(store, {}).status();
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED") << status;
  EXPECT_THAT(std::string(status.message()), HasSubstr("robot 'arm'"));
}

TEST(Replay, TheRestoredWorldIsChargedForItsGeometry) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  PutLarge(*live, Durability::kDurable);
  const auto memory = MemoryBudget::Make(std::int64_t{1} << 30);
  auto replayed = Replay(store, {.memory = memory});
  ASSERT_TRUE(replayed.ok());
  const auto payer = replayed->worlds.front().payer;
  ASSERT_TRUE(payer.has_value());
  EXPECT_GT(memory->world_bytes_of(*payer), 228 * 2 * kSidesOfBlob);
  replayed->worlds.clear();
  EXPECT_EQ(memory->world_bytes(), 0);
}

TEST(Replay, ProgressRisesToTheEnd) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  Story story(journal, 3);
  for (int i = 0; i < 50; ++i) story.WriteTo(*live);
  std::vector<double> shares;
  const auto replayed =
      Replay(store, {.threads = 1, .progress = [&](double share) { shares.push_back(share); }});
  ASSERT_TRUE(replayed.ok());
  EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));
  EXPECT_EQ(shares.back(), 1.0);
}

}  // namespace
}  // namespace cwm::server
