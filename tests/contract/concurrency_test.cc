// Many readers query one snapshot with all engines while a writer publishes new ones. The same
// query to the same snapshot gives the same bytes on every thread.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

constexpr int kReaders = 4;

// Releases all threads at the same time, so that they really race.
class SpinBarrier {
 public:
  explicit SpinBarrier(int count) : waiting_(count) {}
  void Arrive() {
    waiting_.fetch_sub(1);
    while (waiting_.load() > 0) std::this_thread::yield();
  }

 private:
  std::atomic<int> waiting_;
};

std::vector<double> EvaluateAll(const WorldSnapshot& world, const QueryBody& body,
                                const std::vector<Pose>& poses) {
  std::vector<double> bytes;
  for (const EngineChoice engine :
       {EngineChoice::kAuto, EngineChoice::kExact, EngineChoice::kFcl, EngineChoice::kBullet}) {
    QueryOptions options;
    options.engine = engine;
    options.max_results = 3;
    const auto distances = GetDistances(world, body, poses, options);
    EXPECT_TRUE(distances.ok()) << distances.status();
    if (!distances.ok()) return {};
    bytes.insert(bytes.end(), distances->distance_m.begin(), distances->distance_m.end());
    bytes.insert(bytes.end(), distances->point_object.begin(), distances->point_object.end());
    const auto verdicts = CheckCollisions(world, body, poses, options);
    EXPECT_TRUE(verdicts.ok()) << verdicts.status();
    for (const Verdict verdict : verdicts->verdict) bytes.push_back(static_cast<double>(verdict));
  }
  return bytes;
}

TEST(Concurrency, ReadersOfOneSnapshotAgreeWhileAWriterPublishesOthers) {
  std::mt19937 random(9);
  const auto world = RandomWorld(20, random, /*with_meshes=*/true);
  const QueryBody body = Gripper();  // shared by all readers, with its prepared geometry
  const std::vector<Pose> poses = RandomPoses(20, random);
  const std::vector<double> expected = EvaluateAll(*world, body, poses);

  SpinBarrier barrier(kReaders + 1);
  std::atomic<bool> done = false;
  std::vector<std::vector<double>> answers(kReaders);
  std::vector<std::thread> readers;
  for (int i = 0; i < kReaders; ++i) {
    readers.emplace_back([&, i] {
      barrier.Arrive();
      for (int round = 0; round < 3; ++round) answers[i] = EvaluateAll(*world, body, poses);
    });
  }
  std::thread writer([&] {
    std::mt19937 own(10);
    auto latest = world;
    barrier.Arrive();
    while (!done.load()) {
      const std::string name = latest->objects()[own() % latest->objects().size()]->name;
      const Change move{.what = MoveObject{name, RandomPose(own, 1.0)},
                        .expected_object_revision = {}};
      latest = *Apply(latest, {&move, 1});
    }
    EXPECT_GT(latest->revision(), world->revision());
  });
  for (std::thread& reader : readers) reader.join();
  done = true;
  writer.join();
  for (const auto& answer : answers) EXPECT_EQ(answer, expected);
}

TEST(Concurrency, GeometryIsPreparedOnManyThreadsAtOnce) {
  SpinBarrier barrier(kReaders);
  std::vector<std::thread> threads;
  std::vector<double> nearest_m(kReaders);
  for (int i = 0; i < kReaders; ++i) {
    threads.emplace_back([&, i] {
      barrier.Arrive();
      std::mt19937 random(12);
      const auto world = RandomWorld(12, random, /*with_meshes=*/true);
      const std::vector<Pose> at = {Pose::Identity()};
      nearest_m[i] = GetDistances(*world, Gripper(), at, {})->distance_m[0];
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const double distance_m : nearest_m) EXPECT_EQ(distance_m, nearest_m[0]);
}

}  // namespace
}  // namespace cwm::collision
