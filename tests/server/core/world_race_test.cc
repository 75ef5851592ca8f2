// Writers, readers and watches of one world at the same time. Run under the thread sanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/core/error.h"
#include "server/core/world_registry.h"
#include "tests/server/core/replica.h"
#include "tests/server/core/spin_barrier.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using collision::Revision;

constexpr int kWriters = 3;
constexpr int kReaders = 2;
constexpr int kWatches = 4;
constexpr int kWrites = 60;  // per writer: some hundred revisions, a second under the sanitizer

// Runs body(i) on n threads that start together.
template <class Body>
std::vector<std::thread> Race(int n, SpinBarrier& barrier, const Body& body) {
  std::vector<std::thread> threads;
  for (int i = 0; i < n; ++i) {
    threads.emplace_back([&barrier, body, i] {
      barrier.Arrive();
      body(i);
    });
  }
  return threads;
}

void Join(std::vector<std::thread>& threads) {
  for (std::thread& thread : threads) thread.join();
}

// Uses a watch like a transport: sleeps until woken, then reads everything.
class WatchLoop {
 public:
  WatchLoop(World& world, const WatchOptions& options) {
    auto watch = world.Watch(options, [signal = signal_] { signal->Set(); });
    if (watch.ok()) watch_ = *std::move(watch);
    signal_->Set();
  }
  bool started() const { return watch_ != nullptr; }

  // Runs until the watch ends or the revision has been read.
  absl::Status RunUntil(Revision revision) {
    while (true) {
      signal_->Wait();
      const absl::Status status = replica.ReadAll(*watch_);
      if (!status.ok() || replica.revision() >= revision) return status;
    }
  }

  Replica replica;

 private:
  struct Signal {
    std::mutex mutex;
    std::condition_variable woken;
    bool set = false;
    void Set() {
      std::lock_guard lock(mutex);
      set = true;
      woken.notify_one();
    }
    void Wait() {
      std::unique_lock lock(mutex);
      woken.wait(lock, [this] { return set; });
      set = false;
    }
  };
  std::shared_ptr<Signal> signal_ = std::make_shared<Signal>();
  std::unique_ptr<WatchCursor> watch_;
};

WatchMode ModeOf(int i) { return i % 2 == 0 ? WatchMode::kLossless : WatchMode::kCoalesced; }

// Writer i adds, moves and removes objects of its own.
void WriteALot(World& world, int i) {
  for (int n = 0; n < kWrites; ++n) {
    const std::string name = absl::StrCat("w", i, "_", n % 5);
    std::vector<collision::Change> changes = {Put(name, n + 1)};
    if (n % 7 == 6) changes = {Remove(absl::StrCat("w", i, "_", (n - 1) % 5))};
    ASSERT_TRUE(world.Apply(changes, {}).ok());
  }
}

TEST(WorldRace, OfTwoWritersWithTheSameExpectedRevisionOneWins) {
  World world("w", "uid", {});
  for (int round = 0; round < 50; ++round) {
    const Revision expected = world.Snapshot()->revision();
    SpinBarrier barrier(kWriters);
    std::atomic<int> won{0};
    std::atomic<int> aborted{0};
    auto threads = Race(kWriters, barrier, [&](int i) {
      const auto outcome = world.Apply(std::vector{Put(absl::StrCat("o", i), round + 1)},
                                       {.expected_revision = expected});
      if (outcome.ok()) {
        ++won;
      } else if (DetailsOf(outcome.status()).reason == "REVISION_MISMATCH") {
        ++aborted;
      }
    });
    Join(threads);
    ASSERT_EQ(won, 1);
    ASSERT_EQ(aborted, kWriters - 1);
    ASSERT_EQ(world.Snapshot()->revision().value, expected.value + 1);
  }
}

TEST(WorldRace, ARequestSentTwiceAtOnceIsAppliedOnce) {
  World world("w", "uid", {});
  for (int round = 0; round < 50; ++round) {
    SpinBarrier barrier(kWriters);
    std::atomic<int> first{0};
    auto threads = Race(kWriters, barrier, [&](int) {
      const auto outcome =
          world.Apply(std::vector{Put("a", round + 1)},
                      {.request_id = absl::StrCat("r", round), .request_digest = "d"});
      ASSERT_TRUE(outcome.ok());
      EXPECT_EQ(outcome->revision.value, round + 1);
      if (!outcome->replayed) ++first;
    });
    Join(threads);
    ASSERT_EQ(first, 1);
  }
}

TEST(WorldRace, ReadersSeeWholeChangesAndRevisionsThatOnlyGrow) {
  World world("w", "uid", {});
  std::atomic<bool> done{false};
  SpinBarrier barrier(kReaders + 1);
  auto readers = Race(kReaders, barrier, [&](int) {
    Revision last;
    while (!done) {
      const SnapshotPtr snapshot = world.Snapshot();
      ASSERT_GE(snapshot->revision(), last);
      last = snapshot->revision();
      const auto a = snapshot->Find("a");
      const auto b = snapshot->Find("b");
      ASSERT_EQ(a == nullptr, b == nullptr);
      if (a != nullptr) {
        ASSERT_EQ(a->X_WO.translation(), b->X_WO.translation());
      }
      // A published revision can be read exactly, since it enters the history before it is
      // published.
      const auto exact = world.At(Exactly{last}, Clock::time_point::max(), {});
      if (exact.ok()) {
        ASSERT_EQ(*exact, snapshot);
      } else {
        ASSERT_EQ(DetailsOf(exact.status()).reason, "REVISION_COMPACTED");
      }
    }
  });
  auto writer = Race(1, barrier, [&](int) {
    for (int n = 1; n <= 300; ++n) {
      EXPECT_TRUE(world.Apply(std::vector{Put("a", n), Put("b", n)}, {}).ok());
    }
    done = true;
  });
  Join(writer);
  Join(readers);
}

TEST(WorldRace, ThoseWhoWaitForARevisionGetIt) {
  World world("w", "uid", {});
  SpinBarrier barrier(kReaders + 1);
  auto waiters = Race(kReaders, barrier, [&](int) {
    for (int r = 1; r <= kWrites; ++r) {
      const auto snapshot = world.At(AtLeast{{r}}, Clock::time_point::max(), {});
      ASSERT_TRUE(snapshot.ok());
      ASSERT_GE((*snapshot)->revision(), Revision{r});
    }
  });
  auto writer = Race(1, barrier, [&](int) {
    for (int n = 1; n <= kWrites; ++n) {
      ASSERT_TRUE(world.Apply(std::vector{Put("a", n)}, {}).ok());
    }
  });
  Join(writer);
  Join(waiters);
}

TEST(WorldRace, EveryWatchEndsUpWithTheWritersWorld) {
  World world("w", "uid", {});
  const Revision end{std::int64_t{kWriters} * kWrites};
  SpinBarrier barrier(kWriters + kWatches);
  std::vector<Replica> replicas(kWatches);
  auto watches = Race(kWatches, barrier, [&](int i) {
    WatchLoop loop(world, {.mode = ModeOf(i)});
    ASSERT_TRUE(loop.started());
    const absl::Status status = loop.RunUntil(end);
    EXPECT_TRUE(status.ok()) << status;
    replicas[static_cast<std::size_t>(i)] = loop.replica;
  });
  auto writers = Race(kWriters, barrier, [&](int i) { WriteALot(world, i); });
  Join(writers);
  ASSERT_EQ(world.Snapshot()->revision(), end) << "each write has an effect";
  Join(watches);
  for (const Replica& replica : replicas) {
    EXPECT_EQ(replica.objects(), world.Snapshot()->objects());
  }
}

// A client that loses its connection repeatedly misses nothing.
TEST(WorldRace, AWatchThatResumesAgainAndAgainMissesNothing) {
  World world("w", "uid", {});
  const Revision end{std::int64_t{kWriters} * kWrites};
  SpinBarrier barrier(kWriters + 1);
  Replica replica;
  auto watch = Race(1, barrier, [&](int) {
    for (int connection = 0; replica.revision() < end; ++connection) {
      const auto cursor =
          world.Watch({.from_revision = replica.revision(), .mode = ModeOf(connection)}, [] {});
      ASSERT_TRUE(cursor.ok()) << cursor.status();
      for (int step = 0; step < 3; ++step) {
        const auto next = (*cursor)->Next();
        ASSERT_TRUE(next.ok());
        if (next->has_value()) replica.Take(**next);
      }
    }
  });
  auto writers = Race(kWriters, barrier, [&](int i) { WriteALot(world, i); });
  Join(writers);
  Join(watch);
  EXPECT_EQ(replica.objects(), world.Snapshot()->objects());
}

TEST(WorldRace, ASlowLosslessReaderIsEndedAndHoldsNobodyUp) {
  World world("w", "uid", {.watch_events = 8});
  SpinBarrier barrier(kWriters + 1);
  const auto cursor = *world.Watch({}, [] {});
  std::atomic<bool> written{false};
  auto reader = Race(1, barrier, [&](int) {
    ASSERT_TRUE(cursor->Next().ok());
    while (!written) std::this_thread::yield();
    const auto step = cursor->Next();
    EXPECT_EQ(DetailsOf(step.status()).reason, "WATCH_TOO_SLOW");
  });
  auto writers = Race(kWriters, barrier, [&](int i) { WriteALot(world, i); });
  Join(writers);
  written = true;
  Join(reader);
}

TEST(WorldRace, DeletingEndsWatchesWritersAndWaiters) {
  for (int round = 0; round < 10; ++round) {
    World world("w", "uid", {});
    SpinBarrier barrier(kWriters + kWatches + 2);
    std::atomic<std::int64_t> written{0};
    auto watches = Race(kWatches, barrier, [&](int i) {
      WatchLoop loop(world, {.mode = ModeOf(i)});
      if (!loop.started()) return;  // the world was deleted first
      const absl::Status status = loop.RunUntil({std::numeric_limits<std::int64_t>::max()});
      EXPECT_EQ(DetailsOf(status).reason, "WORLD_DELETED");
      // All acknowledged writes have been delivered.
      EXPECT_EQ(loop.replica.objects(), world.Snapshot()->objects());
    });
    auto writers = Race(kWriters, barrier, [&](int i) {
      for (int n = 0;; ++n) {
        const auto outcome = world.Apply(std::vector{Put(absl::StrCat("o", i), n + 1)}, {});
        if (!outcome.ok()) {
          EXPECT_EQ(DetailsOf(outcome.status()).reason, "WORLD_DELETED");
          return;
        }
        ++written;
      }
    });
    auto waiter = Race(1, barrier, [&](int) {
      const auto snapshot = world.At(AtLeast{{std::numeric_limits<std::int64_t>::max()}},
                                     Clock::time_point::max(), {});
      EXPECT_EQ(DetailsOf(snapshot.status()).reason, "WORLD_DELETED");
    });
    auto closer = Race(1, barrier, [&](int) {
      while (written < 20) std::this_thread::yield();
      EXPECT_TRUE(world.Close().ok());
    });
    Join(closer);
    Join(writers);
    Join(waiter);
    Join(watches);
    EXPECT_EQ(world.Snapshot()->revision().value, written);
  }
}

TEST(WorldRace, WorldsMayBeMadeFoundAndDeletedAtOnce) {
  WorldRegistry registry({}, {});
  SpinBarrier barrier(kWriters + 1);
  auto users = Race(kWriters, barrier, [&](int i) {
    for (int n = 0; n < 100; ++n) {
      const auto world = registry.FindOrCreate("w");
      ASSERT_TRUE(world.ok());
      const auto outcome = (*world)->Apply(std::vector{Put(absl::StrCat("o", i), n + 1)}, {});
      if (!outcome.ok()) {
        EXPECT_EQ(DetailsOf(outcome.status()).reason, "WORLD_DELETED");
      }
      EXPECT_LE(registry.List().size(), 1u);
    }
  });
  auto deleter = Race(1, barrier, [&](int) {
    for (int n = 0; n < 100; ++n) {
      const auto deleted = registry.Delete("w");
      if (!deleted.ok()) {
        EXPECT_EQ(DetailsOf(deleted.status()).reason, "WORLD_UNKNOWN");
      }
    }
  });
  Join(users);
  Join(deleter);
}

}  // namespace
}  // namespace cwm::server
