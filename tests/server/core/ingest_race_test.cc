// Scans into a world while others write to it. Run under the thread sanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <set>
#include <thread>
#include <vector>

#include "server/core/ingest.h"
#include "tests/server/core/replica.h"
#include "tests/server/core/spin_barrier.h"
#include "tests/server/core/table_scans.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

constexpr int kScanners = 2;
constexpr int kScans = 4;  // each: a second or so under the sanitizer

// The writer never pauses, so that the optimistic tries fail and the scan must be matched under the
// writer's turn.
TEST(IngestRace, ScansComeThroughAmongOtherWrites) {
  World world("w", "uid", {});
  const TableScan scan = ScanTable(TwoBoxes());
  const auto watch = *world.Watch({}, [] {});
  SpinBarrier barrier(kScanners + 1);
  std::atomic<int> scanning{kScanners};
  std::vector<std::thread> threads;
  for (int i = 0; i < kScanners; ++i) {
    threads.emplace_back([&] {
      barrier.Arrive();
      for (int n = 0; n < kScans; ++n) {
        const auto outcome = Ingest(world, RequestFor(scan), TruthOf(scan), {});
        EXPECT_TRUE(outcome.ok()) << outcome.status();
      }
      --scanning;
    });
  }
  threads.emplace_back([&] {
    barrier.Arrive();
    // Outside the sensor's view.
    int n = 0;
    do {
      EXPECT_TRUE(world.Apply(std::vector{Put("users", -10 - 0.001 * ++n)}, {}).ok());
      std::this_thread::yield();
    } while (scanning > 0);
  });
  for (std::thread& thread : threads) thread.join();
  // However they interleaved, two boxes and a table were found exactly once.
  EXPECT_EQ(NamesIn(*world.Snapshot()),
            (std::vector<std::string>{"object_1", "object_2", "support_1", "users"}));
  for (const char* name : {"object_1", "object_2", "support_1"}) {
    const auto object = world.Snapshot()->Find(name);
    EXPECT_EQ(object->latest_revision(), object->create_revision) << "never touched again";
  }
}

// Only one of two first scans of a sensor without a pose defines the world frame.
TEST(IngestRace, FirstScansOfOneSensorAgreeOnItsPose) {
  const TableScan scan = ScanTable(TwoBoxes());
  for (int round = 0; round < 3; ++round) {
    World world("w", "uid", {});
    SpinBarrier barrier(kScanners);
    std::vector<std::thread> threads;
    std::vector<Pose> poses(kScanners, Pose::Identity());
    for (int i = 0; i < kScanners; ++i) {
      threads.emplace_back([&, i] {
        IngestRequest request = RequestFor(scan);
        request.options.X_WC.reset();
        // Every estimate differs a little, as real ones do.
        const Interpreter interpret = [&](const auto&, const auto& options, std::stop_token) {
          perception::SceneInterpretation scene = scan.truth;
          scene.X_WC.translation().z() += 1e-6 * i;
          if (options.X_WC) scene.X_WC = *options.X_WC;
          return absl::StatusOr<perception::SceneInterpretation>(std::move(scene));
        };
        barrier.Arrive();
        const auto outcome = Ingest(world, request, interpret, {});
        ASSERT_TRUE(outcome.ok()) << outcome.status();
        poses[static_cast<std::size_t>(i)] = outcome->X_WC;
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (const Pose& X_WC : poses) {
      EXPECT_EQ(X_WC.matrix(), world.SensorPoseOf("head")->X_WC.matrix());
    }
    EXPECT_EQ(world.Snapshot()->objects().size(), 3u);
  }
}

}  // namespace
}  // namespace cwm::server
