// Folding a log changes nothing that anybody can tell.
#include "server/store/compaction.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "server/store/stored_world.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/recorded_world.h"
#include "tests/server/store/story.h"

namespace cwm::server {
namespace {

using ::testing::HasSubstr;

void Fold(const std::string& uid, std::int64_t up_to, Store& store) {
  Compaction compaction(uid, up_to, {});
  for (int steps = 0; !compaction.done(); ++steps) {
    ASSERT_LT(steps, 10'000);
    const absl::Status status = compaction.Step(store);
    ASSERT_TRUE(status.ok()) << status;
  }
}

// The world "w".
std::shared_ptr<World> RestoredFrom(Store& store, Journal& journal, const Retention& retention) {
  auto replayed = Replay(store, {.retention = retention, .threads = 2});
  EXPECT_TRUE(replayed.ok()) << replayed.status();
  return Restore(std::move(replayed->worlds.back()), journal, retention);
}

TEST(Compaction, ChangesNothingWhereverTheLogIsFolded) {
  Retention retention = KeepOnlyTheLast(10);
  retention.watch_events = 30;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    MemoryStore store;
    RecordingJournal journal(store);
    const auto live = MakeRecordedWorld("w", "uid", journal, retention);
    const auto other = MakeRecordedWorld("other", "uid-2", journal, retention);
    Story story(journal, seed), other_story(journal, seed + 100);
    ModelSource source(seed);
    std::int64_t folded = 0;
    for (int round = 0; round < 4; ++round) {
      for (int i = 0; i < 200; ++i) {
        story.WriteTo(*live);
        if (i % 3 == 0) other_story.WriteTo(*other);
      }
      // As far back as the window allows.
      const auto records = store.Follow("uid", folded, 1 << 30);
      ASSERT_TRUE(records.ok());
      const auto last = static_cast<int>(records->size()) - 45;
      ASSERT_GT(last, 0);
      const StoredRecord& up_to = (*records)[static_cast<std::size_t>(source.Integer(0, last))];
      folded = up_to.sequence;
      Fold("uid", folded, store);
      EXPECT_EQ(store.Follow("uid", 0, 1)->front().sequence > folded, true);
      const auto snapshots = store.Snapshots();
      ASSERT_EQ(snapshots->size(), 1u);
      EXPECT_EQ(snapshots->front().revision, up_to.revision);
      for (const std::string& hash : snapshots->front().blobs) {
        EXPECT_TRUE(store.GetBlob(hash).ok());
      }
      ExpectSameWorld(*live, *RestoredFrom(store, journal, retention));
    }
  }
}

TEST(Compaction, ASnapshotOfAFoldFoldsToItself) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  Story story(journal, 11);
  for (int i = 0; i < 200; ++i) story.WriteTo(*live);
  Fold("uid", store.last_sequence(), store);
  const auto first = store.Snapshots();
  auto fold = FoldOf(first->front(), {});
  ASSERT_TRUE(fold.ok()) << fold.status();
  store::v1::WorldSnapshot stored;
  ASSERT_TRUE(stored.ParseFromString(first->front().payload));
  EXPECT_GT(stored.objects_size(), 5);
  EXPECT_EQ(fold->Snapshot().SerializeAsString(), stored.SerializeAsString());
}

TEST(Compaction, RequestIdsAreKeptForTheirTimeOnly) {
  const Retention retention{.request_ids = 50};
  WorldFold fold(retention);
  store::v1::Record record;
  record.set_world_uid("uid");
  record.set_created_name("w");
  for (int i = 0; i < 100; ++i) {
    record.set_when_ns(std::int64_t{1'000'000'000} * i * 12);
    record.mutable_write()->mutable_request()->set_id(std::to_string(i));
    ASSERT_TRUE(fold.Apply(record).ok());
    record.clear_created_name();
  }
  // One every 12 s for ten minutes are 51.
  const auto requests = fold.Requests();
  ASSERT_EQ(requests.size(), 50u);
  EXPECT_EQ(requests.front().request().id(), "50");
  EXPECT_EQ(requests.back().request().id(), "99");
}

TEST(Compactor, FoldsALogThatGrewLongAndNoOther) {
  Retention retention = KeepOnlyTheLast(5);
  retention.watch_events = 10;
  MemoryStore store;
  RecordingJournal journal(store);
  Compactor compactor(retention, {.max_records = 20});
  const auto now = std::chrono::system_clock::now();
  const auto live = MakeRecordedWorld("w", "uid", journal, retention);
  std::int64_t told = 0;
  int steps = 0;
  for (int i = 0; i < 100; ++i) {
    const std::vector<collision::Change> put = {Put("a", i)};
    ASSERT_TRUE(live->Apply(put, {}).ok());
    const StoredRecord record = store.Follow("", told, 1)->front();
    told = record.sequence;
    compactor.Add({.world_uid = "uid",
                   .sequence = record.sequence,
                   .when_ns = NanosecondsOf(now),
                   .changes = 1,
                   .bytes = static_cast<std::int64_t>(record.payload.size())});
    if (i < 29) {
      EXPECT_FALSE(compactor.IsDue(now)) << i;
    }
    while (compactor.IsDue(now)) {
      ASSERT_TRUE(compactor.Step(store, now).ok());
      ++steps;
    }
  }
  EXPECT_GT(steps, 3);
  EXPECT_LE(store.stats().record_count, 32);
  EXPECT_GE(store.stats().record_count, 10) << "what watches read stays";
  ExpectSameWorld(*live, *RestoredFrom(store, journal, retention));
}

TEST(Compactor, DropsADeletedWorldWhenItsDeletionNeedsNoReplyAnyMore) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")};
  ASSERT_TRUE(live->Apply(put, {}).ok());
  ASSERT_TRUE(live->Close({.request_id = "r"}).ok());
  auto replayed = Replay(store, {});
  ASSERT_TRUE(replayed.ok());
  Compactor& compactor = replayed->compactor;
  const auto now = std::chrono::system_clock::now();
  EXPECT_FALSE(compactor.IsDue(now + std::chrono::minutes(9)));
  const auto later = now + std::chrono::minutes(11);
  ASSERT_TRUE(compactor.IsDue(later));
  ASSERT_TRUE(compactor.Step(store, later).ok());
  EXPECT_FALSE(compactor.IsDue(later));
  EXPECT_EQ(store.stats().record_count, 0);
  EXPECT_TRUE(Replay(store, {})->worlds.empty());
}

TEST(Compaction, AMissingRecordIsTold) {
  MemoryStore store;
  RecordingJournal journal(store);
  const auto live = MakeRecordedWorld("w", "uid", journal);
  const std::vector<collision::Change> put = {Put("a")};
  ASSERT_TRUE(live->Apply(put, {}).ok());
  Compaction compaction("uid", 5, {});
  absl::Status status;
  for (int i = 0; i < 10 && status.ok(); ++i) status = compaction.Step(store);
  EXPECT_EQ(DetailsOf(status).reason, "STORE_DAMAGED");
  EXPECT_THAT(std::string(status.message()), HasSubstr("record 5"));
}

}  // namespace
}  // namespace cwm::server
