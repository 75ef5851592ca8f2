// Blobs and queues under many threads. Run under the thread sanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "server/core/geometry_store.h"
#include "server/core/work_queue.h"
#include "tests/server/core/spin_barrier.h"

namespace cwm::server {
namespace {

constexpr int kThreads = 4;

TriangleMesh Triangle(double edge_m) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {edge_m, 0, 0}, {0, edge_m, 0}};
  mesh.triangles = {{0, 1, 2}};
  return mesh;
}

TEST(GeometryStoreRace, WritersReadersAndObjectsShareOneStore) {
  GeometryStore store(1'000);  // room for three triangles, so most are dropped again
  SpinBarrier barrier(kThreads);
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&store, &barrier, t] {
      barrier.Arrive();
      for (int n = 0; n < 200; ++n) {
        const auto mesh = std::make_shared<const TriangleMesh>(Triangle(1 + (n + t) % 10));
        const std::string bytes = EncodeMesh(*mesh);
        const std::string hash = n % 2 == 0 ? store.RegisterMesh(mesh) : HashOf(mesh);
        if (n % 2 == 1) {
          ASSERT_TRUE(store.Put(BlobFormat::kMeshF64, bytes).ok());
        }
        const auto blob = store.Get(hash);
        if (n % 2 == 0) {
          ASSERT_TRUE(blob.ok()) << "an object holds the mesh";
        }
        if (blob.ok()) {
          ASSERT_EQ(*(*blob)->bytes, bytes);
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(WorkQueueRace, EveryAcceptedTaskRunsOnceThoughOthersDrain) {
  for (int round = 0; round < 20; ++round) {
    WorkQueue queue({.name = "race", .threads = 2, .capacity = 16});
    std::atomic<int> accepted{0};
    std::atomic<int> run{0};
    SpinBarrier barrier(kThreads + 2);
    std::vector<std::thread> threads;
    for (int t = 0; t < kThreads; ++t) {
      threads.emplace_back([&] {
        barrier.Arrive();
        for (int n = 0; n < 200; ++n) {
          if (queue.TryPush([&run] { ++run; })) ++accepted;
        }
      });
    }
    for (int t = 0; t < 2; ++t) {
      threads.emplace_back([&] {
        barrier.Arrive();
        queue.Drain();
      });
    }
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(run, accepted);
    EXPECT_EQ(queue.waiting(), 0u);
  }
}

}  // namespace
}  // namespace cwm::server
