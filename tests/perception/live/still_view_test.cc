// One frame then and one now of a camera that stands still, in the noise of both.
#include "perception/live/still_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "perception/simulation/frame_errors.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/range_image.h"
#include "tests/perception/live/known_scene.h"

namespace cwm::perception {
namespace {

constexpr std::uint64_t kScenes = 20;

// A camera of its own device before a random table.
struct Table {
  explicit Table(std::uint64_t seed)
      : view(RandomScene(SceneFamily::kTable, seed)),
        device(DrawDeviceErrors(SensorNoise(), view.camera, 100 + seed)) {}

  DeviceReturns ReturnsOf(const SimulatedScene& scene) const {
    DeviceReturns returns{.width = view.camera.width, .height = view.camera.height, .pixels = {}};
    const RangeImage image = Render(scene, view.camera);
    returns.pixels.resize(image.pixels.size());
    ComputeReturns(scene, image, view.camera, device, 0, view.camera.height, returns);
    return returns;
  }
  std::shared_ptr<DepthImage> Frame(const DeviceReturns& returns, std::uint64_t frame) const {
    MeasuredDepth measured = DrawFrame(returns, device.noise, frame);
    return std::make_shared<DepthImage>(DepthImage{.width = measured.width,
                                                   .height = measured.height,
                                                   .depth_m = std::move(measured.depth_m)});
  }
  std::shared_ptr<DepthImage> Frame(const SimulatedScene& scene, std::uint64_t frame) const {
    return Frame(ReturnsOf(scene), frame);
  }
  StillView Still(std::uint64_t frame) const {
    return {CameraOf(view.camera), SensorNoise(), Frame(view.scene, frame)};
  }
  // The object with the most pixels among those that are no support.
  std::size_t LargestObject() const {
    std::vector<int> pixels(view.scene.objects.size(), 0);
    for (const auto& pixel : Render(view.scene, view.camera).pixels) {
      if (pixel.object >= 0) ++pixels[static_cast<std::size_t>(pixel.object)];
    }
    std::size_t best = 0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const bool is_better = view.scene.objects[best].is_support || pixels[i] > pixels[best];
      if (!view.scene.objects[i].is_support && is_better) best = i;
    }
    return best;
  }

  SimulatedView view;
  DeviceErrors device;
};

TEST(StillView, AStaticSceneIsTheSameInItsNoise) {
  std::uint64_t same = 0;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Table table(seed);
    const DeviceReturns returns = table.ReturnsOf(table.view.scene);
    const StillView still(CameraOf(table.view.camera), SensorNoise(), table.Frame(returns, 1));
    const auto now = table.Frame(returns, 2);
    const auto sources = still.Match(*now);
    if (!sources) continue;
    ++same;
    std::size_t returned = 0;
    std::size_t explained = 0;
    for (std::size_t i = 0; i < sources->size(); ++i) {
      if (now->depth_m[i] == 0) {
        EXPECT_EQ((*sources)[i], -1);
        continue;
      }
      ++returned;
      explained += static_cast<std::size_t>((*sources)[i] >= 0);
    }
    EXPECT_GT(explained, returned - returned / 200) << "seed " << seed;
  }
  EXPECT_GE(same, kScenes - 1);
}

TEST(StillView, AThingThatMovedBy20MillimetresIsAChange) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Table table(seed);
    const std::size_t moved = table.LargestObject();
    const double direction_rad = 2.4 * static_cast<double>(seed);
    SimulatedScene scene = table.view.scene;
    scene.objects[moved].X_WO.pretranslate(
        0.02 * Vector3(std::cos(direction_rad), std::sin(direction_rad), 0));
    EXPECT_FALSE(table.Still(1).Match(*table.Frame(scene, 2))) << "seed " << seed;
  }
}

TEST(StillView, AThingThatWentOrCameIsAChange) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Table table(seed);
    SimulatedScene less = table.view.scene;
    less.objects.erase(less.objects.begin() + static_cast<std::ptrdiff_t>(table.LargestObject()));
    const auto without = table.Frame(less, 2);
    EXPECT_FALSE(table.Still(1).Match(*without)) << "seed " << seed;
    const StillView empty(CameraOf(table.view.camera), SensorNoise(), without);
    EXPECT_FALSE(empty.Match(*table.Frame(table.view.scene, 3))) << "seed " << seed;
  }
}

TEST(StillView, ACubeOf30MillimetresIsAChange) {
  std::uint64_t seen = 0;
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    const Table table(seed);
    SimulatedScene more = table.view.scene;
    const Aabb top = BoundsInWorld(more.objects[0]);
    const Vector3 middle = top.center();
    more.objects.push_back(
        {.name = "cube",
         .parts = {{Pose::Identity(), Box{Vector3::Constant(0.03)}}},
         .X_WO = MakeTranslation(middle.x() + 0.1 * std::cos(2.4 * static_cast<double>(seed)),
                                 middle.y() + 0.1 * std::sin(2.4 * static_cast<double>(seed)),
                                 top.max().z() + 0.015)});
    const auto index = static_cast<std::int32_t>(more.objects.size() - 1);
    int pixels = 0;
    for (const auto& pixel : Render(more, table.view.camera).pixels) {
      pixels += static_cast<int>(pixel.object == index);
    }
    if (pixels < 100) continue;  // others hide it
    ++seen;
    EXPECT_FALSE(table.Still(1).Match(*table.Frame(more, 2))) << "seed " << seed;
  }
  EXPECT_GE(seen, kScenes / 2);
}

TEST(StillView, ACameraThatTurnedByAThirdOfADegreeIsAChange) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Table table(seed);
    Table turned = table;
    turned.view.camera.X_WC.rotate(Eigen::AngleAxisd(0.006, Vector3::UnitX()));
    EXPECT_FALSE(table.Still(1).Match(*turned.Frame(table.view.scene, 2))) << "seed " << seed;
  }
}

// A wall without noise.
class WallTest : public ::testing::Test {
 protected:
  static constexpr int kWidth = 64, kHeight = 48;
  static constexpr float kDepth_m = 1;

  DepthImage Wall() const {
    return {.width = kWidth,
            .height = kHeight,
            .depth_m = std::vector<float>(std::size_t{kWidth} * kHeight, kDepth_m)};
  }
  static void Fill(DepthImage& image, int u, int v, int edge, float depth_m) {
    for (int dv = 0; dv < edge; ++dv) {
      for (int du = 0; du < edge; ++du) {
        image.depth_m[static_cast<std::size_t>((v + dv) * kWidth + u + du)] = depth_m;
      }
    }
  }
  auto Match(const DepthImage& before, const DepthImage& now) const {
    return StillView(camera_, SensorNoise(), std::make_shared<DepthImage>(before)).Match(now);
  }

  const DepthCamera camera_{.pinhole = {60, 60, 31.5, 23.5}, .width = kWidth, .height = kHeight};
};

TEST_F(WallTest, ReturnsInAWideHoleAreAChangeAndLostOnesAreNoEvidence) {
  DepthImage holed = Wall();
  Fill(holed, 8, 8, 20, 0);
  EXPECT_FALSE(Match(holed, Wall()));
  const auto sources = Match(Wall(), holed);
  ASSERT_TRUE(sources);
  EXPECT_EQ((*sources)[10 * kWidth + 10], -1);
  DepthImage pierced = Wall();
  Fill(pierced, 8, 8, 8, 0);
  EXPECT_TRUE(Match(pierced, Wall())) << "what is around it explains it";
}

TEST_F(WallTest, ANewReturnTakesThePlaceOfItsSurface) {
  DepthImage before = Wall();
  before.depth_m[10 * kWidth + 10] = 0;
  const auto sources = Match(before, Wall());
  ASSERT_TRUE(sources);
  const std::set<std::int32_t> beside = {9 * kWidth + 10, 11 * kWidth + 10, 10 * kWidth + 9,
                                         10 * kWidth + 11};
  EXPECT_TRUE(beside.contains((*sources)[10 * kWidth + 10]));
}

TEST_F(WallTest, ADepthThatNothingExplainsHasNoSource) {
  DepthImage now = Wall();
  now.depth_m[10 * kWidth + 10] = 0.5F;  // one pixel is no change
  const auto sources = Match(Wall(), now);
  ASSERT_TRUE(sources);
  EXPECT_EQ((*sources)[10 * kWidth + 10], -1);
  EXPECT_EQ((*sources)[10 * kWidth + 11], 10 * kWidth + 11);
}

TEST_F(WallTest, AnEdgeMayShiftByItsNoiseAndItsPixelsTakeTheSideThatTheyShow) {
  DepthImage before = Wall();
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < 20; ++u) before.depth_m[static_cast<std::size_t>(v * kWidth + u)] = 0.6F;
  }
  DepthImage now = before;
  for (int v = 0; v < kHeight; v += 2)
    now.depth_m[static_cast<std::size_t>(v * kWidth + 20)] = 0.6F;
  const auto sources = Match(before, now);
  ASSERT_TRUE(sources);
  EXPECT_EQ((*sources)[20], 19);
  EXPECT_EQ((*sources)[kWidth + 20], kWidth + 20);
}

TEST_F(WallTest, AShiftBelowTheNoiseOfAPixelIsTheSumOfABlock) {
  // derived: at 1 m a block's mean tells 5 sqrt(2) sqrt(13 / 64) 1.9 mm = 6 mm, and 4 x 4 blocks 3
  // mm; one pixel tells 13 mm.
  DepthImage one = Wall();
  Fill(one, 16, 16, 8, kDepth_m - 0.008F);
  EXPECT_FALSE(Match(Wall(), one));
  DepthImage patch = Wall();
  Fill(patch, 0, 0, 32, kDepth_m - 0.004F);
  EXPECT_FALSE(Match(Wall(), patch));
  DepthImage little = Wall();
  Fill(little, 16, 16, 8, kDepth_m - 0.004F);
  EXPECT_TRUE(Match(Wall(), little));
}

}  // namespace
}  // namespace cwm::perception
