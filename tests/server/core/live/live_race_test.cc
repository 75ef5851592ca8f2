// Three sensors, their joint states, writers and readers of one world at once.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "server/core/live/live_worlds.h"
#include "server/core/work_queue.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/core/test_objects.h"

namespace cwm::server {
namespace {

using perception::Stamp;

constexpr Stamp kBegin{std::chrono::hours(400'000)};
constexpr int kFrames = 40;
constexpr int kWidth = 64, kHeight = 48;

// A wall at 2 m; from the fifth frame on something at 1.2 m passes before it.
LiveFrame FrameOf(int k) {
  LiveFrame frame;
  frame.stamp = kBegin + std::chrono::milliseconds(33 * k);
  frame.camera = {.pinhole = {.focal_u_px = kWidth,
                              .focal_v_px = kWidth,
                              .center_u_px = 0.5 * (kWidth - 1),
                              .center_v_px = 0.5 * (kHeight - 1)},
                  .width = kWidth,
                  .height = kHeight};
  auto image = std::make_shared<perception::DepthImage>();
  image->width = kWidth;
  image->height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const bool passes = k >= 5 && u / 16 == k % 4 && v > 12 && v < 36;
      image->depth_m.push_back(passes ? 1.2F : 2.0F);
    }
  }
  frame.image = std::move(image);
  frame.received = frame.begun = frame.decoded = Clock::now();
  return frame;
}

TEST(LiveRaceTest, SensorsWritersAndReadersShareAWorld) {
  const auto world = std::make_shared<World>("w", "uid", Retention{});
  ASSERT_TRUE(
      world
          ->Apply(std::vector{collision::testing::MakeChange(collision::testing::PutArm("arm"))},
                  {})
          .ok());
  WorkQueue beside({.name = "beside", .threads = 1, .capacity = 8});
  LiveWorlds worlds(
      {.interpret = [](const auto&, const auto&,
                       std::stop_token) { return absl::UnimplementedError("no interpreter"); },
       .run_beside =
           [&beside](std::function<void()> task) { return beside.TryPush(std::move(task)); }});
  const std::shared_ptr<LiveWorld> live = worlds.Of(world);
  std::atomic<int> processed = 0;
  std::atomic<bool> is_over = false;
  std::vector<std::thread> sensors;
  for (int s = 0; s < 3; ++s) {
    sensors.emplace_back([&, s] {
      SensorCalibration calibration{.sensor = "sensor_" + std::to_string(s)};
      calibration.X_WC = MakeTranslation(0, s, 0);
      auto stream = live->Open(calibration, {});
      ASSERT_TRUE(stream.ok()) << stream.status();
      for (int k = 0; k < kFrames; ++k) {
        const auto outcome = (*stream)->Process(FrameOf(k));
        ASSERT_TRUE(outcome.ok()) << outcome.status();
        EXPECT_EQ(outcome->fate, FrameFate::kProcessed) << outcome->message;
        ++processed;
      }
    });
  }
  std::thread writer([&] {
    for (int i = 0; !is_over; ++i) {
      EXPECT_TRUE(world->Apply(std::vector{Put("a", i)}, {}).ok());
      EXPECT_TRUE(world->Apply(std::vector{Remove("a")}, {}).ok());
    }
  });
  std::thread robot([&] {
    const int variables[] = {0};
    for (int k = 0; !is_over; ++k) {
      const StampedRobotState state{.stamp = kBegin + std::chrono::milliseconds(k % 1'500),
                                    .values = {0.001 * (k % 500)}};
      const auto arm = world->Snapshot()->FindRobot("arm");
      world->robot_states().Add(*arm, variables, {&state, 1}, state.stamp).status().IgnoreError();
    }
  });
  std::thread reader([&] {
    std::uint64_t last = 0;
    while (!is_over) {
      for (const auto& frame : live->FramesAfter(last, "")) last = frame->number;
      EXPECT_LE(live->Sensors().size(), 3U);
      live->ForgetGone(Clock::now());
    }
  });
  for (std::thread& sensor : sensors) sensor.join();
  is_over = true;
  for (std::thread* thread : {&writer, &robot, &reader}) thread->join();
  EXPECT_EQ(processed, 3 * kFrames);
  // The movers of all three are gone with them.
  worlds.ForgetGone(Clock::now() + std::chrono::seconds(3));
  for (const auto& object : world->Snapshot()->objects()) {
    EXPECT_NE(object->kind, collision::ObjectKind::kMover) << object->name;
  }
  worlds.Forget(*world);
  EXPECT_FALSE(live->Open({.sensor = "late"}, {}).ok());
  beside.Drain();
}

}  // namespace
}  // namespace cwm::server
