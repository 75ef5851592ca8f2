// What clients and readers see of writes that the journal does not have yet.
#include "server/core/commit_pipeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/core/error.h"
#include "tests/server/core/held_journal.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;
using testing::ElementsAre;
using testing::IsEmpty;

absl::Status DiskFull() {
  return MakeError(absl::StatusCode::kResourceExhausted, "no room", {.reason = "DISK_FULL"});
}

class CommitPipelineTest : public testing::Test {
 protected:
  // Starts a write; its answer becomes the next of `answers`.
  void Start(const std::vector<Change>& changes, const WriteOptions& options = {}) {
    world->StartApply(changes, options, nullptr, [this](absl::StatusOr<WriteOutcome> outcome) {
      answers.push_back(std::move(outcome));
    });
  }
  // "ok at 3", "ok at 3 again" for the reply to a retry, or the reason.
  std::vector<std::string> Answers() const {
    std::vector<std::string> texts;
    for (const auto& answer : answers) {
      texts.push_back(!answer.ok() ? DetailsOf(answer.status()).reason
                                   : "ok at " + std::to_string(answer->revision.value) +
                                         (answer->replayed ? " again" : ""));
    }
    return texts;
  }

  HeldJournal journal;
  std::shared_ptr<World> world = std::make_shared<World>("w", "uid", Retention(), Clock::now,
                                                         WorldServices{.journal = &journal});
  std::vector<absl::StatusOr<WriteOutcome>> answers;
};

TEST_F(CommitPipelineTest, AWriteIsVisibleAndAnsweredWhenTheJournalHasIt) {
  Start({Put("a")});
  Start({Put("b")});
  EXPECT_THAT(Answers(), IsEmpty());
  EXPECT_EQ(world->Snapshot()->revision(), Revision{0});
  EXPECT_EQ(world->Tip()->revision(), Revision{2});
  ASSERT_EQ(journal.waiting(), 2u);
  EXPECT_EQ(journal.entry(0).created_name, "w");
  EXPECT_EQ(journal.entry(1).created_name, std::nullopt);

  journal.Answer();
  EXPECT_THAT(Answers(), ElementsAre("ok at 1"));
  EXPECT_THAT(NamesIn(*world->Snapshot()), ElementsAre("a"));
  journal.Answer();
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "ok at 2"));
  EXPECT_THAT(NamesIn(*world->Snapshot()), ElementsAre("a", "b"));
  EXPECT_EQ(world->Tip(), world->Snapshot());
}

TEST_F(CommitPipelineTest, AnswersThatDependOnAWriteWaitForIt) {
  Start({Put("a")}, {.request_id = "first"});
  Start({Remove("missing")});
  Start({Put("a")}, {.request_id = "first"});
  Start({Put("b")}, {.expected_revision = Revision{0}});
  Start({Put("a")});
  EXPECT_THAT(Answers(), IsEmpty());
  EXPECT_EQ(journal.waiting(), 1u);
  journal.Answer();
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "OBJECT_UNKNOWN", "ok at 1 again",
                                     "REVISION_MISMATCH", "ok at 1"));
}

TEST_F(CommitPipelineTest, AFullDiskTakesBackWhatWasNotJournaled) {
  Start({Put("a")});
  journal.Answer();
  Start({Put("b")}, {.request_id = "id"});
  Start({Move("b", 1)});
  Start({Remove("missing")});
  journal.AnswerAll(DiskFull());
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "DISK_FULL", "DISK_FULL", "DISK_FULL"));
  EXPECT_EQ(world->Tip(), world->Snapshot());
  EXPECT_THAT(NamesIn(*world->Tip()), ElementsAre("a"));

  // There is room again: the retry is done now, and only now.
  Start({Put("b")}, {.request_id = "id"});
  journal.Answer();
  EXPECT_EQ(Answers().back(), "ok at 2");
  EXPECT_THAT(NamesIn(*world->Snapshot()), ElementsAre("a", "b"));
}

TEST_F(CommitPipelineTest, AWriteAfterARefusalIsRefusedWithTheEntriesBeforeIt) {
  Start({Put("a")});
  journal.Answer(DiskFull());
  Start({Put("b")});
  Start({Put("c")});
  // The journal refuses entries that came while it refused the first one.
  journal.AnswerAll(DiskFull());
  EXPECT_THAT(Answers(), ElementsAre("DISK_FULL", "DISK_FULL", "DISK_FULL"));
  Start({Put("d")});
  EXPECT_EQ(journal.entry(0).created_name, "w") << "the journal does not know the world yet";
  journal.Answer();
  EXPECT_THAT(NamesIn(*world->Snapshot()), ElementsAre("d"));
  EXPECT_EQ(world->Snapshot()->revision(), Revision{1});
}

TEST_F(CommitPipelineTest, NamesAreNotGivenTwiceAfterARefusal) {
  std::vector<std::string> names;
  const auto put_new = [&] {
    std::thread writer([&] {
      const auto make = [&](const SnapshotPtr&) -> absl::StatusOr<std::vector<Change>> {
        names.push_back(world->ReserveName("object"));
        return std::vector{Put(names.back())};
      };
      answers.push_back(world->Update(make, {}));
    });
    while (journal.waiting() == 0) std::this_thread::yield();
    return writer;
  };
  std::thread first = put_new();
  journal.Answer(DiskFull());
  first.join();
  std::thread second = put_new();
  EXPECT_THAT(std::get<WorldWrite>(journal.entry(0).what).last_numbers,
              ElementsAre(testing::Pair("object", 2)));
  journal.Answer();
  second.join();
  EXPECT_THAT(names, ElementsAre("object_1", "object_2"));
  EXPECT_THAT(Answers(), ElementsAre("DISK_FULL", "ok at 1"));
}

TEST_F(CommitPipelineTest, APoseIsKeptForTheNextScanUntilItsWriteIsRefused) {
  absl::Status kept;
  std::thread writer([&] {
    kept = world->SetSensorPose("head", {MakeTranslation(1, 0, 0), true});
  });
  while (journal.waiting() == 0) std::this_thread::yield();
  EXPECT_TRUE(world->SensorPoseOf("head").has_value());
  journal.Answer(DiskFull());
  writer.join();
  EXPECT_EQ(DetailsOf(kept).reason, "DISK_FULL");
  EXPECT_FALSE(world->SensorPoseOf("head").has_value());
}

TEST_F(CommitPipelineTest, TooManyWaitingWritesAreRefused) {
  world = std::make_shared<World>("w", "uid", Retention(), Clock::now,
                                  WorldServices{.max_pending_writes = 2, .journal = &journal});
  for (const char* name : {"a", "b", "c"}) Start({Put(name)});
  EXPECT_EQ(journal.waiting(), 2u);
  journal.AnswerAll();
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "ok at 2", "QUEUE_FULL"));
}

TEST_F(CommitPipelineTest, ADeletedWorldStaysUntilTheJournalHasItsEnd) {
  Start({Put("a")});
  journal.Answer();
  absl::StatusOr<Revision> closed = absl::UnknownError("");
  const auto close = [&] {
    std::thread closer([&] { closed = world->Close({.requested_uid = "uid", .request_id = "x"}); });
    while (journal.waiting() == 0) std::this_thread::yield();
    return closer;
  };
  std::thread first = close();
  Start({Put("b")});
  journal.AnswerAll(DiskFull());
  first.join();
  EXPECT_EQ(DetailsOf(closed.status()).reason, "DISK_FULL");
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "DISK_FULL"));

  Start({Put("b")});
  journal.Answer();
  std::thread second = close();
  EXPECT_EQ(std::get<WorldDeletion>(journal.entry(0).what).request_id, "x");
  Start({Put("c")});
  journal.Answer();
  second.join();
  ASSERT_TRUE(closed.ok());
  EXPECT_EQ(*closed, Revision{2});
  EXPECT_THAT(Answers(), ElementsAre("ok at 1", "DISK_FULL", "ok at 2", "WORLD_DELETED"));
}

TEST_F(CommitPipelineTest, OneDurableChangeMakesTheListDurable) {
  const Change expire{.what = collision::ExpireRules{Clock::now()}, .expected_object_revision = {}};
  Start({expire});
  Start({expire, Put("b")});
  EXPECT_EQ(journal.entry(0).durability, Durability::kObserved);
  EXPECT_EQ(journal.entry(1).durability, Durability::kDurable);
  journal.AnswerAll();
}

}  // namespace
}  // namespace cwm::server
