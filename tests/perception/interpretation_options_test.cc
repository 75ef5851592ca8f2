// The options that a caller sets: when an interpretation ends and where the sensor was; and the
// effort that it saves to end in time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "perception/interpret_scene.h"
#include "perception/simulation/random_draws.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

struct Interpreted {
  absl::StatusCode code = absl::StatusCode::kOk;
  int pieces = 0;
  int after_stop = 0;  // number of pieces that began after the stop
};

// Interprets the cloud and requests a stop when piece `stop_at` begins.
Interpreted InterpretUntil(const PointCloud& cloud, int max_threads, int stop_at) {
  std::stop_source source;
  std::atomic<int> pieces{0}, after_stop{0};
  InterpretOptions options;
  options.max_threads = max_threads;
  options.on_chunk = [&] {
    if (source.stop_requested()) ++after_stop;
    if (++pieces == stop_at) source.request_stop();
  };
  const auto scene = InterpretScene(cloud, options, source.get_token());
  return {scene.status().code(), pieces, after_stop};
}

PointCloud Shuffled(PointCloud cloud) {  // unordered like a laser's cloud: no image
  cloud.width = static_cast<int>(cloud.size());
  cloud.height = 1;
  return cloud;
}

TEST(InterpretScene, EndsWithinAPieceOfEachThreadWhereverTheStopStrikes) {
  constexpr int kStops = 10;
  const PointCloud image = Scan(KitchenCounter(), KitchenCamera(), {}).cloud;
  for (const PointCloud& cloud : {image, Shuffled(image)}) {
    const Interpreted whole = InterpretUntil(cloud, 1, -1);
    ASSERT_EQ(whole.code, absl::StatusCode::kOk);
    // The work takes some hundred milliseconds, in pieces of at most one: stops strike in every
    // stage.
    ASSERT_GT(whole.pieces, 1000);
    for (const int threads : {1, 2}) {
      for (int k = 1; k < kStops; ++k) {
        const int stop_at = whole.pieces * k / kStops;
        const Interpreted run = InterpretUntil(cloud, threads, stop_at);
        EXPECT_EQ(run.code, absl::StatusCode::kCancelled) << k;
        EXPECT_GE(run.pieces, stop_at);
        EXPECT_LE(run.after_stop, threads - 1);  // pieces that the other threads had just begun
      }
    }
  }
}

TEST(InterpretScene, JudgesReachOnlyFromAGivenPose) {
  const PointCloud cloud = Scan(KitchenCounter(), KitchenCamera(), {}).cloud;
  InterpretOptions options;
  options.X_WC = KitchenCamera().X_WC;
  const auto given = InterpretScene(cloud, options);
  options.X_WC_source = InterpretOptions::PoseSource::kEstimated;
  const auto kept = InterpretScene(cloud, options);
  ASSERT_TRUE(given.ok() && kept.ok());
  ASSERT_FALSE(given->supports.empty());
  EXPECT_EQ(given->supports[0].reachable, true);  // the counter's top is at 0.9 m
  ASSERT_EQ(kept->supports.size(), given->supports.size());
  for (const DetectedSupport& support : kept->supports) EXPECT_FALSE(support.reachable.has_value());
}

TEST(InterpretScene, SaysWhereUpContradictsTheGivenPose) {
  const PointCloud cloud = Scan(KitchenCounter(), KitchenCamera(), {}).cloud;
  InterpretOptions options;
  options.X_WC = KitchenCamera().X_WC;
  options.up_C = options.X_WC->linear().row(2).transpose();
  const auto contradicts = ::testing::HasSubstr("contradicts x_world_sensor by 90 degrees");
  EXPECT_THAT(InterpretScene(cloud, options)->report.warnings,
              ::testing::Not(::testing::Contains(contradicts)));
  options.up_C = options.X_WC->linear().row(0).transpose();
  EXPECT_THAT(InterpretScene(cloud, options)->report.warnings, ::testing::Contains(contradicts));
}

// The counter with `count` balls on it, in rows, apart from each other.
SimulatedScene Balls(int count) {
  SimulatedScene scene = KitchenCounter();
  std::erase_if(scene.objects, [](const SimulatedObject& object) { return !object.is_support; });
  constexpr double kRadius_m = 0.02, kPitch_m = 0.065, kTop_m = 0.9, kNearest_m = 0.4;
  constexpr int kPerRow = 13;
  for (int k = 0; k < count; ++k) {
    const int row = k / kPerRow, from_middle = k % kPerRow - kPerRow / 2;
    const Pose X_WO =
        MakeTranslation(kNearest_m + kPitch_m * row, kPitch_m * from_middle, kTop_m + kRadius_m);
    scene.objects.push_back({.parts = {{Pose::Identity(), Sphere{kRadius_m}}}, .X_WO = X_WO});
  }
  return scene;
}

TEST(InterpretScene, SaysWhereObjectsWereTooManyToBeCutOrUnhurried) {
  const auto cut = ::testing::HasSubstr("alone were looked at for objects that touch");
  const auto reduced_effort = ::testing::HasSubstr("were modelled with reduced effort");
  for (const int count : {20, 35, 112}) {
    const auto scene = InterpretScene(Scan(Balls(count), KitchenCamera(), {}).cloud, {});
    ASSERT_TRUE(scene.ok()) << scene.status();
    ASSERT_GE(scene->objects.size(), static_cast<std::size_t>(count));
    const auto is_told = [&](const auto& what) {
      return ::testing::Matches(::testing::Contains(what))(scene->report.warnings);
    };
    EXPECT_EQ(is_told(cut), count > 25);
    EXPECT_EQ(is_told(reduced_effort), count > 100);
  }
}

// Objects that are modelled with reduced effort still get their shape.
TEST(InterpretScene, FindsBallsAtReducedEffort) {
  const auto scene = InterpretScene(Scan(Balls(112), KitchenCamera(), {}).cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  const auto balls = std::ranges::count_if(scene->objects, [](const DetectedObject& object) {
    return object.model->shapes.size() == 1 &&
           std::holds_alternative<Sphere>(object.model->shapes.front().shape);
  });
  EXPECT_GE(balls, 110);
}

// An image of clods of noise in the air, in this many rows and columns.
PointCloud Clods(int rows, int columns) {
  constexpr int kSize_px = 14, kPitch_px = 24;
  RandomDraws draws(1, 0);
  PointCloud cloud;
  cloud.width = columns * kPitch_px;
  cloud.height = rows * kPitch_px;
  for (int v = 0; v < cloud.height; ++v) {
    for (int u = 0; u < cloud.width; ++u) {
      const bool is_hit = u % kPitch_px < kSize_px && v % kPitch_px < kSize_px;
      const double depth_m =
          is_hit ? 1 + 0.05 * std::sin(u / 1.7) * std::sin(v / 1.7) + 0.004 * draws.Normal()
                 : std::numeric_limits<double>::quiet_NaN();
      const Vector3 ray((u - 0.5 * cloud.width) / 300, (v - 0.5 * cloud.height) / 300, 1);
      cloud.points.push_back((depth_m * ray).cast<float>());
    }
  }
  return cloud;
}

// If the largest objects have no shape, the others are meshed without a search for shapes, and a
// warning says so. No point is lost.
TEST(InterpretScene, LooksForNoShapesWhereTheLargestObjectsAreNone) {
  const PointCloud cloud = Clods(7, 8);
  const auto scene = InterpretScene(cloud, {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  ASSERT_GT(scene->objects.size(), 25u);
  EXPECT_THAT(scene->report.warnings,
              ::testing::Contains(::testing::HasSubstr("hardly anything is a shape")));
  EXPECT_GE(scene->report.points_explained + scene->report.points_rejected,
            scene->report.points_finite);
  for (const DetectedObject& object : scene->objects) {
    EXPECT_FALSE(object.model->surfaces.empty() && object.model->shapes.empty());
  }
}

}  // namespace
}  // namespace cwm::perception
