#include "perception/hypotheses/scene_rays.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr int kAcross = 200;  // points of a plane two metres away, 5 mm apart
constexpr int kMiddle = kAcross / 2;
constexpr float kPitch_m = 0.005f;
constexpr int kHalfObject = 20;  // points of an object in its middle, on either side of it

Vector3f At(int column, int row) {
  return {kPitch_m * static_cast<float>(column - kMiddle),
          kPitch_m * static_cast<float>(row - kMiddle), 2};
}

bool IsOfObject(int column, int row) {
  return std::abs(column - kMiddle) <= kHalfObject && std::abs(row - kMiddle) <= kHalfObject;
}

// An object in the middle of a wall, both seen from the origin.
SegmentedScene ObjectOnWall() {
  SegmentedScene scene;
  SegmentedHypothesis& hypothesis = scene.hypotheses.emplace_back();
  for (int row = 0; row < kAcross; ++row) {
    for (int column = 0; column < kAcross; ++column) {
      if (IsOfObject(column, row)) {
        hypothesis.points.push_back(static_cast<std::uint32_t>(scene.points.points.size()));
      }
      scene.points.points.push_back(At(column, row));
      scene.points.sigma_m.push_back(0.002f);
    }
  }
  scene.sight.emplace(scene.points, kPitch_m);
  return scene;
}

TEST(SceneRays, AreNoneOfACloudThatMayHaveBeenSeenFromSeveralPlaces) {
  SegmentedScene scene = ObjectOnWall();
  scene.sight.reset();
  EXPECT_TRUE(SceneRays(scene, kSerialWork)
                  .PassingRaysOf(scene.hypotheses[0].points, std::nullopt, kSerialWork)
                  .ends.empty());
}

TEST(SceneRays, PassAnObjectWhereTheyEndBesideItAndNotOnIt) {
  const SegmentedScene scene = ObjectOnWall();
  const PassingRays rays =
      SceneRays(scene, kSerialWork)
          .PassingRaysOf(scene.hypotheses[0].points, std::nullopt, kSerialWork);
  ASSERT_FALSE(rays.ends.empty());
  EXPECT_EQ(rays.ends.size(), rays.sigma_m.size());
  const float half_m = kPitch_m * kHalfObject;
  for (const Vector3f& end : rays.ends) {
    const float away_m = end.head<2>().cwiseAbs().maxCoeff();
    EXPECT_GT(away_m, half_m);
    EXPECT_LT(away_m, 2 * half_m);  // 30 % of its width and 40 mm at two metres
  }
}

TEST(SceneRays, RunBelowAnObjectThatHangsAboveWhatItStandsOn) {
  const SegmentedScene scene = ObjectOnWall();
  Pose X_LSupport = MakeTranslation(0, 0.3, 2);  // y points down
  X_LSupport.linear() = BasisFromZ(-Vector3::UnitY());
  const PassingRays rays = SceneRays(scene, kSerialWork)
                               .PassingRaysOf(scene.hypotheses[0].points, X_LSupport, kSerialWork);
  const PassingRays unknown =
      SceneRays(scene, kSerialWork)
          .PassingRaysOf(scene.hypotheses[0].points, std::nullopt, kSerialWork);
  ASSERT_EQ(rays.around_count, unknown.ends.size());
  EXPECT_EQ(unknown.around_count, unknown.ends.size());
  EXPECT_TRUE(std::equal(unknown.ends.begin(), unknown.ends.end(), rays.ends.begin()));
  ASSERT_GT(rays.ends.size(), rays.around_count);
  const float beside_m = 2 * kPitch_m * kHalfObject;
  float lowest_m = 0;
  for (std::size_t k = rays.around_count; k < rays.ends.size(); ++k) {
    EXPECT_LT(std::abs(rays.ends[k].x()), beside_m);
    lowest_m = std::max(lowest_m, rays.ends[k].y());
  }
  EXPECT_GT(lowest_m, 0.29f);  // metres: down to its foot
}

TEST(SceneRays, StandForAllThatWereMeasured) {
  const SegmentedScene scene = ObjectOnWall();
  SegmentedScene dense = scene;  // every point four times
  for (int k = 0; k < 3; ++k) {
    dense.points.points.insert(dense.points.points.end(), scene.points.points.begin(),
                               scene.points.points.end());
    dense.points.sigma_m.insert(dense.points.sigma_m.end(), scene.points.sigma_m.begin(),
                                scene.points.sigma_m.end());
  }
  const PassingRays one = SceneRays(scene, kSerialWork)
                              .PassingRaysOf(scene.hypotheses[0].points, std::nullopt, kSerialWork);
  const PassingRays four =
      SceneRays(dense, kSerialWork)
          .PassingRaysOf(dense.hypotheses[0].points, std::nullopt, kSerialWork);
  EXPECT_EQ(one.weight, 1);
  EXPECT_EQ(four.weight, 4);
}

TEST(SceneRays, EndWhenStopped) {
  const SegmentedScene scene = ObjectOnWall();
  std::stop_source stop;
  stop.request_stop();
  SegmentedScene large = scene;
  for (int k = 0; k < 20; ++k) {
    large.hypotheses[0].points.insert(large.hypotheses[0].points.end(),
                                      scene.hypotheses[0].points.begin(),
                                      scene.hypotheses[0].points.end());
  }
  EXPECT_THROW(SceneRays(large, {.stop = stop.get_token()}), Stopped);
}

}  // namespace
}  // namespace cwm::perception
