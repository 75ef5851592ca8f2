#include "server/core/history.h"

#include <gtest/gtest.h>

#include "server/core/approximate_bytes.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Change;
using collision::Revision;

const Clock::time_point kStart{};

// A history fed with real changes.
class Recorder {
 public:
  explicit Recorder(Retention retention)
      : latest_(std::make_shared<const collision::WorldSnapshot>()), history(retention, latest_) {}

  void Record(std::vector<Change> changes, Clock::time_point when = kStart) {
    SnapshotPtr next = *collision::Apply(latest_, changes);
    auto deltas = collision::Difference(*latest_, *next);
    history.Append(next, std::make_shared<const Event>(
                             Event{next->revision(), when, {deltas.begin(), deltas.end()}}));
    latest_ = std::move(next);
  }

 private:
  SnapshotPtr latest_;

 public:
  History history;
};

TEST(History, BeginsWithTheEmptyWorldAtRevisionZero) {
  Recorder recorder({});
  EXPECT_EQ(recorder.history.latest(), Revision{0});
  EXPECT_EQ(recorder.history.oldest_exact(), Revision{0});
  EXPECT_EQ(recorder.history.oldest_watch(), Revision{0});
  EXPECT_TRUE(recorder.history.SnapshotAt({0})->objects().empty());
  EXPECT_EQ(recorder.history.SnapshotAt({1}), nullptr);
  EXPECT_EQ(recorder.history.EventFrom({0}), nullptr);
}

TEST(History, KeepsTheLastSnapshotsExactly) {
  Recorder recorder({.exact_snapshots = 3, .recent_snapshots = 0});
  for (int i = 1; i <= 10; ++i) recorder.Record({Put("a", i)});
  EXPECT_EQ(recorder.history.oldest_exact(), Revision{8});
  EXPECT_EQ(recorder.history.SnapshotAt({7}), nullptr);
  for (int i = 8; i <= 10; ++i) {
    EXPECT_EQ(recorder.history.SnapshotAt({i})->Find("a")->X_WO.translation().x(), i);
  }
}

TEST(History, SnapshotsEndAtTheirMemoryCapButTheLatestStays) {
  Recorder recorder({.snapshot_bytes = 1});
  recorder.Record({Put("a")});
  recorder.Record({Put("b")});
  EXPECT_EQ(recorder.history.oldest_exact(), Revision{2});
  EXPECT_NE(recorder.history.SnapshotAt({2}), nullptr);
}

TEST(History, EventsEndAtTheirCountMemoryAndAge) {
  Recorder counted({.watch_events = 4});
  for (int i = 1; i <= 5; ++i) counted.Record({Put("a", i), Put("b", i)});
  EXPECT_EQ(counted.history.oldest_watch(), Revision{3});
  EXPECT_EQ(counted.history.EventFrom({2}), nullptr);
  EXPECT_EQ(counted.history.EventFrom({3})->deltas.size(), 2u);

  Recorder weighed({.watch_bytes = 1});
  weighed.Record({Put("a")});
  weighed.Record({Put("b")});
  EXPECT_EQ(weighed.history.oldest_watch(), Revision{1}) << "the newest event is always kept";

  Recorder aged({.watch_time = std::chrono::seconds(10)});
  aged.Record({Put("a")}, kStart);
  aged.Record({Put("b")}, kStart + std::chrono::seconds(5));
  aged.history.Expire(kStart + std::chrono::seconds(10));
  EXPECT_EQ(aged.history.oldest_watch(), Revision{0});
  aged.history.Expire(kStart + std::chrono::seconds(11));
  EXPECT_EQ(aged.history.oldest_watch(), Revision{1});
  aged.history.Expire(kStart + std::chrono::seconds(16));
  EXPECT_EQ(aged.history.oldest_watch(), Revision{2});
  EXPECT_TRUE(aged.history.EventsAfter({2}).empty());
}

TEST(History, UndoingEventsLeadsBackToEachSnapshot) {
  Recorder recorder({});
  recorder.Record({Put("a"), Put("b", 1)});
  recorder.Record({Move("a", 2), Remove("b")});
  recorder.Record({Put("b", 3), Put("c"), Remove("a"), Put("a", 5)});
  recorder.Record({Remove("a"), Move("c", 4)});
  const SnapshotPtr latest = recorder.history.SnapshotAt({4});
  for (int r = 0; r <= 4; ++r) {
    const SnapshotPtr expected = recorder.history.SnapshotAt({r});
    const SnapshotPtr undone = UndoEvents(*latest, recorder.history.EventsAfter({r}), {r});
    EXPECT_EQ(undone->revision(), expected->revision());
    EXPECT_EQ(undone->objects(), expected->objects()) << "at revision " << r;
  }
}

TEST(ApproximateBytes, CountsWhatHistoryAloneHolds) {
  Recorder recorder({});
  recorder.Record({Put("a")});
  recorder.Record({Move("a", 1)});
  recorder.Record({Remove("a")});
  const auto superseded = [&](int revision) {
    return ApproximateSupersededBytes(recorder.history.EventFrom({revision - 1})->deltas);
  };
  const auto whole = ApproximateBytes(*recorder.history.SnapshotAt({2})->Find("a"));
  EXPECT_EQ(superseded(1), 0) << "an addition supersedes nothing";
  EXPECT_GT(superseded(2), 0);
  EXPECT_LT(superseded(2), whole) << "a move shares the geometry with its successor";
  EXPECT_EQ(superseded(3), whole);
}

TEST(ApproximateBytes, OfASnapshotThatDiffersInOneObjectGrowAsItsPathsDo) {
  const auto world_of = [](int count) {
    std::vector<Change> changes;
    for (int i = 0; i < count; ++i) changes.push_back(Put("object_" + std::to_string(i), i));
    return *collision::Apply(std::make_shared<const collision::WorldSnapshot>(), changes);
  };
  const SnapshotPtr small = world_of(10), large = world_of(10'000);
  EXPECT_GT(ApproximateOwnBytes(*large, 1), ApproximateOwnBytes(*small, 1));
  EXPECT_LT(ApproximateOwnBytes(*large, 1), 6'000);
  EXPECT_EQ(ApproximateOwnBytes(*small, 10), ApproximateOwnBytes(*small))
      << "one that shares nothing";
}

}  // namespace
}  // namespace cwm::server
