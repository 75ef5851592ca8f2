// What the compactor leaves as it is, and when it tries again.
#include <gtest/gtest.h>

#include "server/core/error.h"
#include "server/store/compaction.h"
#include "tests/server/core/test_objects.h"
#include "tests/server/store/recorded_world.h"
#include "tests/server/store/store_wrapper.h"

namespace cwm::server {
namespace {

const collision::WallTime kNow = collision::WallTime(std::chrono::hours(24 * 365 * 55));

// A store that refuses snapshots, and does not give them all.
class RefusingStore final : public StoreWrapper {
 public:
  explicit RefusingStore(Store& store) : StoreWrapper(store) {}
  absl::Status PutSnapshot(const StoredSnapshot& snapshot) override {
    ++puts;
    return refusal.ok() ? StoreWrapper::PutSnapshot(snapshot) : refusal;
  }
  absl::StatusOr<std::vector<StoredSnapshot>> Snapshots() override {
    ADD_FAILURE() << "a compaction needs the snapshot of its world alone";
    return StoreWrapper::Snapshots();
  }

  absl::Status refusal;
  int puts = 0;
};

// A world whose records, of which `compactor` is told, leave the window at once.
class CompactorLimits : public ::testing::Test {
 protected:
  static constexpr std::int64_t kMaxRecords = 20;
  const Retention retention_{.exact_snapshots = 1, .watch_events = 1};

  void Write(int count, Compactor& compactor) {
    for (int i = 0; i < count; ++i) {
      const std::vector<collision::Change> put = {Put("a", ++written_)};
      ASSERT_TRUE(live_->Apply(put, {}).ok());
      const auto record = store_.Follow("uid", told_, 1);
      ASSERT_TRUE(record.ok() && !record->empty());
      told_ = record->front().sequence;
      compactor.Add({.world_uid = "uid",
                     .sequence = told_,
                     .when_ns = NanosecondsOf(kNow),
                     .changes = 1,
                     .bytes = static_cast<std::int64_t>(record->front().payload.size())});
    }
  }
  void StepWhileDue(Compactor& compactor) {
    for (int steps = 0; compactor.IsDue(kNow); ++steps) {
      ASSERT_LT(steps, 100);
      const absl::Status status = compactor.Step(refusing_, kNow);
      ASSERT_TRUE(status.ok()) << status;
    }
  }

  MemoryStore store_;
  RefusingStore refusing_{store_};
  RecordingJournal journal_{store_};
  std::shared_ptr<World> live_ = MakeRecordedWorld("w", "uid", journal_, retention_);
  std::int64_t told_ = 0;
  int written_ = 0;
};

TEST_F(CompactorLimits, ASnapshotThatTheStoreFindsTooLargeIsTriedAgainWhenTheLogHasDoubled) {
  Compactor compactor(retention_, {.max_records = kMaxRecords});
  refusing_.refusal = MakeError(absl::StatusCode::kResourceExhausted, "too large",
                                {.reason = "SNAPSHOT_TOO_LARGE"});
  Write(25, compactor);
  StepWhileDue(compactor);
  EXPECT_EQ(compactor.not_folded(), 1);
  EXPECT_EQ(refusing_.puts, 1);
  EXPECT_EQ(store_.stats().record_count, 25) << "the log is as it was";
  Write(14, compactor);
  EXPECT_FALSE(compactor.IsDue(kNow)) << "it has not doubled";
  refusing_.refusal = absl::OkStatus();
  Write(14, compactor);
  EXPECT_TRUE(compactor.IsDue(kNow));
  StepWhileDue(compactor);
  EXPECT_EQ(compactor.not_folded(), 1);
  EXPECT_LT(store_.stats().record_count, 20);
  Write(30, compactor);
  EXPECT_TRUE(compactor.IsDue(kNow)) << "the limits are again those of before";
}

TEST_F(CompactorLimits, ASnapshotAboveTheLimitIsNotGivenToTheStore) {
  Compactor compactor(retention_, {.max_records = kMaxRecords, .max_snapshot_bytes = 10});
  Write(25, compactor);
  StepWhileDue(compactor);
  EXPECT_EQ(compactor.not_folded(), 1);
  EXPECT_EQ(refusing_.puts, 0);
  EXPECT_EQ(store_.stats().record_count, 25);
}

TEST_F(CompactorLimits, AFullDiskIsTriedAgainAfterAWhile) {
  Compactor compactor(retention_, {.max_records = kMaxRecords});
  refusing_.refusal = Overloaded("the disk is full", "DISK_FULL", 1);
  Write(25, compactor);
  absl::Status status;
  for (int i = 0; i < 100 && status.ok(); ++i) status = compactor.Step(refusing_, kNow);
  EXPECT_EQ(DetailsOf(status).reason, "DISK_FULL");
  const auto before_end = kNow + Compactor::kWaitWhenFull - std::chrono::milliseconds(1);
  EXPECT_FALSE(compactor.IsDue(kNow));
  EXPECT_FALSE(compactor.IsDue(before_end));
  EXPECT_TRUE(compactor.Step(refusing_, before_end).ok());
  EXPECT_EQ(refusing_.puts, 1) << "nothing is tried meanwhile";
  EXPECT_TRUE(compactor.IsDue(kNow - std::chrono::hours(1))) << "the clock was set back";
  refusing_.refusal = absl::OkStatus();
  const auto end = kNow + Compactor::kWaitWhenFull;
  ASSERT_TRUE(compactor.IsDue(end));
  ASSERT_TRUE(compactor.Step(refusing_, end).ok());
  EXPECT_FALSE(compactor.IsDue(end));
  EXPECT_EQ(refusing_.puts, 2);
  EXPECT_LT(store_.stats().record_count, 20);
  EXPECT_EQ(compactor.not_folded(), 0);
}

}  // namespace
}  // namespace cwm::server
