// The journal's thread against stores that are slow, full, forgetful or broken.
#include "server/store/store_journal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/core/error.h"
#include "server/core/world.h"
#include "server/store/memory_store.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/store_wrapper.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;
using testing::Each;
using testing::ElementsAre;

absl::Status DiskFull() {
  return MakeError(absl::StatusCode::kResourceExhausted, "no room", {.reason = "DISK_FULL"});
}

// A store in memory whose next appends can be held, refused or answered wrongly.
class TroubledStore final : public StoreWrapper {
 public:
  struct Trouble {
    std::mutex mutex;
    std::condition_variable changed;
    bool is_held = false;
    bool has_room = true;
    absl::Status refusal;                  // of appends; OK: none
    std::vector<AppendResult> answers;     // of the next appends, in place of the true ones
    bool writes_unknown = true;            // whether an append that is answered kUnknown is done
    std::vector<std::size_t> batches;      // sizes of all appends that were done
    std::vector<Durability> durabilities;  // likewise

    void Set(const std::function<void()>& change) {
      const std::lock_guard lock(mutex);
      change();
      changed.notify_all();
    }
  };

  TroubledStore(Store& store, Trouble& trouble) : StoreWrapper(store), trouble_(trouble) {}

  absl::StatusOr<AppendResult> Append(std::span<const StoredRecord> records,
                                      Durability durability) override {
    std::unique_lock lock(trouble_.mutex);
    trouble_.changed.wait(lock, [this] { return !trouble_.is_held; });
    if (!trouble_.refusal.ok()) return trouble_.refusal;
    AppendResult answer = AppendResult::kDurable;
    if (!trouble_.answers.empty()) {
      answer = trouble_.answers.front();
      trouble_.answers.erase(trouble_.answers.begin());
    }
    const bool writes = answer == AppendResult::kDurable ||
                        (answer == AppendResult::kUnknown && trouble_.writes_unknown);
    if (!writes) return answer;
    trouble_.batches.push_back(records.size());
    trouble_.durabilities.push_back(durability);
    const auto appended = StoreWrapper::Append(records, durability);
    return appended.ok() ? absl::StatusOr<AppendResult>(answer) : appended;
  }
  absl::Status CheckRoom() override {
    const std::lock_guard lock(trouble_.mutex);
    return trouble_.has_room ? absl::OkStatus() : DiskFull();
  }

 private:
  Trouble& trouble_;
};

class StoreJournalTest : public testing::Test {
 protected:
  StoreJournalTest() { Open(); }

  void Open() {
    journal = std::make_unique<StoreJournal>(
        std::make_unique<TroubledStore>(memory, trouble), Compactor(),
        [this](const absl::Status& status) { failure.set_value(status); });
  }
  std::shared_ptr<World> MakeWorld(std::string name) {
    std::string uid = "uid of " + name;
    return std::make_shared<World>(std::move(name), std::move(uid), Retention(), Clock::now,
                                   WorldServices{.journal = journal.get()});
  }
  // Writes after a refusal. The journal may still refuse what comes while it refuses what came
  // before.
  Revision ApplyWithRoom(World& world, const std::vector<Change>& changes) {
    for (;;) {
      const auto outcome = world.Apply(changes, {});
      if (outcome.ok()) return outcome->revision;
      EXPECT_EQ(DetailsOf(outcome.status()).reason, "DISK_FULL");
    }
  }
  std::future<absl::StatusOr<WriteOutcome>> Start(World& world,
                                                  const std::vector<Change>& changes) {
    auto answer = std::make_shared<std::promise<absl::StatusOr<WriteOutcome>>>();
    world.StartApply(changes, {}, nullptr, [answer](absl::StatusOr<WriteOutcome> outcome) {
      answer->set_value(std::move(outcome));
    });
    return answer->get_future();
  }

  TroubledStore::Trouble trouble;
  std::shared_ptr<MemoryDisk> disk = std::make_shared<MemoryDisk>();
  MemoryStore memory{disk};
  std::promise<absl::Status> failure;
  std::unique_ptr<StoreJournal> journal;
};

TEST_F(StoreJournalTest, WritesThatCameDuringACommitShareTheNext) {
  const auto world = MakeWorld("w");
  trouble.Set([&] { trouble.is_held = true; });
  std::vector<std::future<absl::StatusOr<WriteOutcome>>> answers;
  for (int i = 0; i < 20; ++i) answers.push_back(Start(*world, {Put("o" + std::to_string(i))}));
  EXPECT_EQ(world->Snapshot()->revision(), Revision{0});
  trouble.Set([&] { trouble.is_held = false; });
  for (int i = 0; i < 20; ++i)
    EXPECT_EQ(answers[static_cast<std::size_t>(i)].get()->revision.value, i + 1);
  EXPECT_LE(trouble.batches.size(), 3u);
  EXPECT_THAT(trouble.durabilities, Each(Durability::kDurable));
  EXPECT_EQ(journal->info().sequence, 20);
}

TEST_F(StoreJournalTest, AFullDiskRefusesWritesAndLetsThemThroughWhenThereIsRoom) {
  const auto world = MakeWorld("w"), other = MakeWorld("other");
  ASSERT_TRUE(world->Apply(std::vector{Put("a")}, {}).ok());
  trouble.Set([&] { trouble.is_held = true; });
  std::vector<std::future<absl::StatusOr<WriteOutcome>>> refused;
  for (const char* name : {"b", "c", "d"}) {
    refused.push_back(Start(*world, {Put(name)}));
    refused.push_back(Start(*other, {Put(name)}));
  }
  trouble.Set([&] {
    trouble.refusal = DiskFull();
    trouble.is_held = false;
  });
  for (auto& answer : refused) EXPECT_EQ(DetailsOf(answer.get().status()).reason, "DISK_FULL");
  EXPECT_EQ(journal->info().refuses_writes, "no room");
  EXPECT_THAT(NamesIn(*world->Snapshot()), ElementsAre("a"));
  trouble.Set([&] { trouble.refusal = absl::OkStatus(); });
  EXPECT_EQ(ApplyWithRoom(*world, {Put("e")}), Revision{2});
  EXPECT_EQ(ApplyWithRoom(*other, {Put("e")}), Revision{1});
  EXPECT_EQ(journal->info().refuses_writes, "");
  EXPECT_EQ(disk->last_sequence, 3);
}

TEST_F(StoreJournalTest, AnAllowanceEndsThoughThereIsNoRoom) {
  const auto world = MakeWorld("w");
  const auto start = Clock::now();
  const Change allow{.what = collision::AllowCollision{.pair = {{"a"}, {"b"}},
                                                       .expires = collision::ExpiryAfter(
                                                           std::chrono::seconds(1), start)},
                     .expected_object_revision = {}};
  ASSERT_TRUE(world->Apply(std::vector{Put("a"), Put("b"), allow}, {}).ok());
  trouble.Set([&] { trouble.has_room = trouble.is_held = false; });
  trouble.Set([&] { trouble.is_held = true; });
  std::thread expiry(
      [&] { EXPECT_TRUE(world->ExpireRules(start + std::chrono::seconds(2)).ok()); });
  while (world->Tip()->revision() != Revision{2}) std::this_thread::yield();
  auto put = Start(*world, {Put("c")});  // behind it, in the same or in the next batch
  trouble.Set([&] { trouble.is_held = false; });
  expiry.join();
  EXPECT_EQ(DetailsOf(put.get().status()).reason, "DISK_FULL");
  EXPECT_TRUE(world->Snapshot()->pair_rules().empty());
  EXPECT_EQ(world->Tip(), world->Snapshot());
  trouble.Set([&] { trouble.has_room = true; });
  EXPECT_EQ(ApplyWithRoom(*world, {Put("c")}), Revision{3});
}

// Writers that go on while the disk is full and free in turn: what is acknowledged is in the store,
// each revision once.
TEST_F(StoreJournalTest, UnderChangingRoomTheStoreHasJustWhatWasAcknowledged) {
  constexpr int kWriters = 4, kWrites = 200;
  const auto world = MakeWorld("w");
  std::atomic<bool> is_over = false;
  std::thread disk_user([&] {
    for (bool is_full = true; !is_over; is_full = !is_full) {
      trouble.Set([&] { trouble.refusal = is_full ? DiskFull() : absl::OkStatus(); });
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
    trouble.Set([&] { trouble.refusal = absl::OkStatus(); });
  });
  std::vector<std::thread> writers;
  std::array<std::vector<std::int64_t>, kWriters> acknowledged;
  for (int w = 0; w < kWriters; ++w) {
    writers.emplace_back([&, w] {
      for (int i = 0; i < kWrites; ++i) {
        const auto outcome = world->Apply(std::vector{Put("o" + std::to_string(w), i + 0.5)}, {});
        if (outcome.ok())
          acknowledged[static_cast<std::size_t>(w)].push_back(outcome->revision.value);
      }
    });
  }
  for (std::thread& writer : writers) writer.join();
  is_over = true;
  disk_user.join();
  ASSERT_TRUE(journal->Close().ok());
  std::vector<std::int64_t> revisions, stored;
  for (const auto& each : acknowledged) revisions.insert(revisions.end(), each.begin(), each.end());
  std::sort(revisions.begin(), revisions.end());
  for (const auto& [sequence, record] : disk->records) stored.push_back(record.revision);
  EXPECT_EQ(revisions, stored);
  EXPECT_FALSE(revisions.empty());
  EXPECT_EQ(world->Snapshot()->revision().value, static_cast<std::int64_t>(revisions.size()));
}

TEST_F(StoreJournalTest, ALostReplyIsAskedForAgain) {
  const auto world = MakeWorld("w");
  for (const bool writes : {true, false}) {
    trouble.Set([&] {
      trouble.answers = {AppendResult::kUnknown};
      trouble.writes_unknown = writes;
    });
    ASSERT_TRUE(world->Apply(std::vector{Put("a", writes ? 1 : 2)}, {}).ok());
  }
  EXPECT_EQ(disk->records.size(), 2u);
}

TEST_F(StoreJournalTest, AFailedStoreEndsEverything) {
  const auto world = MakeWorld("w");
  trouble.Set([&] {
    trouble.refusal = MakeError(absl::StatusCode::kUnavailable, "an error of the disk",
                                {.reason = "STORE_FAILED"});
  });
  const auto answer = Start(*world, {Put("a")});
  EXPECT_EQ(failure.get_future().get().message(), "an error of the disk");
  EXPECT_EQ(answer.wait_for(std::chrono::milliseconds(50)), std::future_status::timeout)
      << "it is unknown whether the write was stored";
  EXPECT_EQ(world->Snapshot()->revision(), Revision{0});
}

TEST_F(StoreJournalTest, ASecondWriterOfTheStoreEndsTheFirst) {
  const auto world = MakeWorld("w");
  trouble.Set([&] { trouble.answers = {AppendResult::kSuperseded}; });
  const auto answer = Start(*world, {Put("a")});
  EXPECT_THAT(std::string(failure.get_future().get().message()),
              testing::HasSubstr("another server"));
}

TEST_F(StoreJournalTest, ABackupIsMadeWhileItWrites) {
  const auto world = MakeWorld("w");
  ASSERT_TRUE(world->Apply(std::vector{Put("a")}, {}).ok());
  std::promise<absl::StatusOr<std::shared_ptr<const Backup>>> made;
  journal->StartBackup([&](auto backup) { made.set_value(std::move(backup)); });
  ASSERT_TRUE(world->Apply(std::vector{Put("b")}, {}).ok());
  std::promise<absl::Status> second;  // asked for while the first may be under way
  journal->StartBackup([&](const auto& backup) { second.set_value(backup.status()); });
  const auto backup = made.get_future().get();
  EXPECT_TRUE(second.get_future().get().ok());
  ASSERT_TRUE(backup.ok()) << backup.status();
  EXPECT_GE((*backup)->sequence(), 1);
  ASSERT_TRUE(journal->Close().ok());
  std::promise<absl::Status> late;
  journal->StartBackup([&](const auto& none) { late.set_value(none.status()); });
  EXPECT_EQ(DetailsOf(late.get_future().get()).reason, "SERVER_DRAINING");
}

}  // namespace
}  // namespace cwm::server
