// Batches in chunks: how chunks end, and that every query gives the same bytes on any number of
// threads.
#include "collision/query/row_chunks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <random>
#include <stdexcept>
#include <stop_token>
#include <thread>

#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// Ends chunks as the test's script says.
class ScriptedWorker : public ChunkWorker {
 public:
  using Script = std::function<ChunkResult(const RowChunk&)>;
  explicit ScriptedWorker(const Script& script) : script_(script) {}
  ChunkResult Process(const RowChunk& chunk) override { return script_(chunk); }

 private:
  const Script& script_;
};

absl::StatusOr<std::size_t> Process(std::size_t rows, int threads,
                                    const ScriptedWorker::Script& script) {
  return ProcessChunks(EqualChunks(rows, 10), threads,
                       [&] { return std::make_unique<ScriptedWorker>(script); });
}

ChunkResult Whole(const RowChunk& chunk) { return {chunk.count}; }

TEST(ProcessChunks, AsksForEachRowOnce) {
  for (const std::size_t rows : {0U, 1U, 10U, 95U}) {
    for (const int threads : {0, 1, 2, 4}) {
      std::vector<std::atomic<int>> calls(rows);
      const auto completed = Process(rows, threads, [&](const RowChunk& chunk) {
        for (std::size_t k = 0; k < chunk.count; ++k) ++calls[chunk.first + k];
        return Whole(chunk);
      });
      EXPECT_EQ(*completed, rows);
      for (const auto& times : calls) EXPECT_EQ(times, 1);
    }
  }
}

TEST(ProcessChunks, EndsWithTheFirstChunkThatIsNotWhole) {
  for (const int threads : {1, 2, 4}) {
    const auto completed = Process(100, threads, [](const RowChunk& chunk) -> ChunkResult {
      if (chunk.index == 3) {
        std::this_thread::sleep_for(milliseconds(5));  // others finish later chunks meanwhile
        return {4};
      }
      return Whole(chunk);
    });
    EXPECT_EQ(*completed, 34U);
  }
}

TEST(ProcessChunks, TellsTheErrorOfTheFirstChunkThatHasOne) {
  for (const int threads : {1, 2, 4}) {
    const auto completed = Process(100, threads, [](const RowChunk& chunk) -> ChunkResult {
      if (chunk.index < 2) return Whole(chunk);
      if (chunk.index == 2) std::this_thread::sleep_for(milliseconds(5));
      return {1, absl::UnimplementedError(std::to_string(chunk.index))};
    });
    EXPECT_EQ(completed.status(), absl::UnimplementedError("2"));
  }
}

TEST(ProcessChunks, NoErrorBehindTheEndOfTimeIsTold) {
  for (const int threads : {1, 2, 4}) {
    const auto completed = Process(100, threads, [](const RowChunk& chunk) -> ChunkResult {
      if (chunk.index == 0) {
        std::this_thread::sleep_for(milliseconds(5));
        return {3};
      }
      return {0, absl::UnimplementedError("behind")};
    });
    EXPECT_EQ(*completed, 3U);
  }
}

TEST(ProcessChunks, AnExceptionOfAnyThreadIsTheCallers) {
  for (const int threads : {1, 2, 4}) {
    const auto answer = [&] {
      return Process(100, threads, [](const RowChunk& chunk) -> ChunkResult {
        if (chunk.index == 5) throw std::runtime_error("no memory");
        return Whole(chunk);
      });
    };
    EXPECT_THROW(static_cast<void>(answer()), std::runtime_error);
  }
}

void ExpectSame(const CollisionColumns& a, const CollisionColumns& b) {
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.body_part, b.body_part);
  EXPECT_EQ(a.object_part, b.object_part);
  EXPECT_EQ(a.accuracy, b.accuracy);
}

void ExpectSame(const PairColumns& a, const PairColumns& b) {
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.row_begin, b.row_begin);
  EXPECT_EQ(a.distance_m, b.distance_m);
  EXPECT_EQ(a.point_body, b.point_body);
  EXPECT_EQ(a.point_object, b.point_object);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.body_part, b.body_part);
  EXPECT_EQ(a.object_part, b.object_part);
  EXPECT_EQ(a.accuracy, b.accuracy);
  EXPECT_EQ(a.bound_m, b.bound_m);
}

void ExpectSame(const RayColumns& a, const RayColumns& b) {
  EXPECT_EQ(a.completed, b.completed);
  EXPECT_EQ(a.hit, b.hit);
  EXPECT_EQ(a.distance_m, b.distance_m);
  EXPECT_EQ(a.normal, b.normal);
  EXPECT_EQ(a.object, b.object);
  EXPECT_EQ(a.object_part, b.object_part);
}

// Queries of several chunks each, in a world with shapes of all kinds.
class BatchTest : public ::testing::Test {
 protected:
  BatchTest() {
    std::uniform_real_distribution<double> place(-1, 1);
    for (int i = 0; i < 3000; ++i) {
      const Vector3 from(place(random_), place(random_), place(random_));
      const Vector3 to(place(random_), place(random_), place(random_));
      rays_.push_back({.origin = 2 * from, .direction = (to - from).normalized()});
    }
  }

  // Expects the same answers from `query` on one thread and on several.
  template <class Query>
  void ExpectSameOnAnyNumberOfThreads(const Query& query) {
    QueryOptions options{.margin_m = 0.02, .max_results = 3};
    const auto alone = query(options);
    ASSERT_TRUE(alone.ok()) << alone.status();
    for (const int threads : {2, 4}) {
      options.threads = threads;
      ExpectSame(*alone, *query(options));
    }
  }

  // Expects a query whose time runs out to return a prefix of the full answer; `first(n)` answers
  // its first n rows.
  template <class Query, class First>
  void ExpectPrefixes(std::size_t rows, const Query& query, const First& first) {
    for (const int threads : {1, 2, 4}) {
      QueryOptions options{.threads = threads};
      // The budget grows until some rows are answered, however slow the machine is.
      std::chrono::duration<double> budget = std::chrono::microseconds(200);
      auto some = query(options);
      for (some->completed = 0; some->completed == 0; budget *= 1.25) {
        options.deadline =
            steady_clock::now() + std::chrono::duration_cast<steady_clock::duration>(budget);
        some = query(options);
      }
      ASSERT_LT(some->completed, rows);
      ExpectSame(*first(some->completed), *some);
    }
  }

  std::mt19937 random_{11};
  std::shared_ptr<const WorldSnapshot> world_ = RandomWorld(40, random_, /*with_meshes=*/true);
  QueryBody body_ = Gripper();
  std::vector<Pose> poses_ = RandomPoses(1500, random_);
  std::vector<RayRow> rays_;
};

TEST_F(BatchTest, ChecksAreTheSameOnAnyNumberOfThreads) {
  ExpectSameOnAnyNumberOfThreads([&](const QueryOptions& options) {
    return CheckCollisions(*world_, body_, poses_, options);
  });
}

TEST_F(BatchTest, DistancesAreTheSameOnAnyNumberOfThreads) {
  ExpectSameOnAnyNumberOfThreads(
      [&](const QueryOptions& options) { return GetDistances(*world_, body_, poses_, options); });
}

TEST_F(BatchTest, ContactsAreTheSameOnAnyNumberOfThreads) {
  ExpectSameOnAnyNumberOfThreads(
      [&](const QueryOptions& options) { return GetContacts(*world_, body_, poses_, options); });
}

TEST_F(BatchTest, RaysAreTheSameOnAnyNumberOfThreads) {
  ExpectSameOnAnyNumberOfThreads(
      [&](const QueryOptions& options) { return CastRays(*world_, rays_, options); });
}

TEST_F(BatchTest, TimeThatIsUpLeavesThePrefixOfDistances) {
  std::vector<Pose> many;
  for (int i = 0; i < 40; ++i) many.insert(many.end(), poses_.begin(), poses_.end());
  ExpectPrefixes(
      many.size(),
      [&](const QueryOptions& options) { return GetDistances(*world_, body_, many, options); },
      [&](std::size_t rows) {
        return GetDistances(*world_, body_, std::span(many).first(rows), {});
      });
}

// If each answer takes a tenth of the time limit, at most ten are counted, besides those that
// threads had begun.
TEST_F(BatchTest, AnswersEndWhereHandingThemOverTakesTheTimeThatIsLeft) {
  constexpr std::size_t kMaxChunkRows = 1024;    // most rows are counted at the end of a chunk
  constexpr std::size_t kRowsBetweenPolls = 64;  // rows between checks of the clock
  for (const int threads : {1, 2}) {
    const auto options = [&] {
      return QueryOptions{.threads = threads,
                          .deadline = steady_clock::now() + std::chrono::seconds(2),
                          .handover_per_entry = milliseconds(200)};
    };
    const std::size_t max_rows =
        static_cast<std::size_t>(threads) * (kMaxChunkRows + kRowsBetweenPolls);
    EXPECT_LE(CheckCollisions(*world_, body_, poses_, options())->completed, max_rows);
    EXPECT_LE(CastRays(*world_, rays_, options())->completed, max_rows);
    const auto distances = GetDistances(*world_, body_, poses_, options());
    EXPECT_GT(distances->completed, 0U);
    EXPECT_LE(distances->completed, static_cast<std::size_t>(threads) * (10 + kRowsBetweenPolls));
  }
}

TEST_F(BatchTest, TimeThatIsUpLeavesThePrefixOfRays) {
  std::vector<RayRow> many;
  for (int i = 0; i < 40; ++i) many.insert(many.end(), rays_.begin(), rays_.end());
  ExpectPrefixes(
      many.size(), [&](const QueryOptions& options) { return CastRays(*world_, many, options); },
      [&](std::size_t rows) { return CastRays(*world_, std::span(many).first(rows), {}); });
}

// Every row has a verdict: rows behind the prefix are not computed, even if a thread had computed
// them.
TEST_F(BatchTest, TimeThatIsUpLeavesThePrefixOfChecks) {
  std::vector<Pose> many;
  for (int i = 0; i < 40; ++i) many.insert(many.end(), poses_.begin(), poses_.end());
  ExpectPrefixes(
      many.size(),
      [&](const QueryOptions& options) { return CheckCollisions(*world_, body_, many, options); },
      [&](std::size_t rows) {
        auto columns = CheckCollisions(*world_, body_, std::span(many).first(rows), {});
        columns->verdict.resize(many.size(), Verdict::kNotComputed);
        columns->object.resize(many.size(), -1);
        columns->body_part.resize(many.size(), -1);
        columns->object_part.resize(many.size(), -1);
        columns->accuracy.resize(many.size(), Accuracy::kDegraded);
        return columns;
      });
}

TEST_F(BatchTest, AStoppedQuestionIsCancelledOnAllItsThreads) {
  std::vector<Pose> many;
  for (int i = 0; i < 400; ++i) many.insert(many.end(), poses_.begin(), poses_.end());
  for (const int threads : {1, 4}) {
    std::stop_source stop;
    std::jthread stopper([&] {
      std::this_thread::sleep_for(milliseconds(20));
      stop.request_stop();
    });
    const auto columns = GetDistances(*world_, body_, many, {.max_results = 64, .threads = threads},
                                      stop.get_token());
    EXPECT_EQ(columns.status().code(), absl::StatusCode::kCancelled);
  }
}

}  // namespace
}  // namespace cwm::collision
