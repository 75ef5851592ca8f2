// The segmentation compared with the virtual scanner's ground truth.
#include "perception/segmentation/segment_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>
#include <random>

#include "perception/simulation/virtual_scanner.h"
#include "tests/perception/steep_camera.h"

namespace cwm::perception {
namespace {

// The smallest overlap with which a scored object counts as matched, as in the scorer of the data
// set.
constexpr double kMinOverlap = 0.75;

SimulatedObject BoxAt(const std::string& name, const Vector3& size_m, const Vector3& middle_m) {
  SimulatedObject object;
  object.name = name;
  object.parts.push_back({Pose::Identity(), Box{size_m}});
  object.X_WO = MakeTranslation(middle_m.x(), middle_m.y(), middle_m.z());
  return object;
}

SimulatedScene Table(std::vector<SimulatedObject> objects) {
  SimulatedScene scene;
  scene.objects.push_back(BoxAt("table", {1.2, 1.0, 0.03}, {0, 0, -0.015}));
  scene.objects[0].is_support = true;
  for (SimulatedObject& object : objects) scene.objects.push_back(std::move(object));
  return scene;
}

SegmentedScene Segmented(const PointCloud& cloud, const SegmentOptions& options = {},
                         const Work& work = {.max_threads = 2}) {
  auto scene = SegmentScene(*CollectMeasured(cloud, {}), options, work);
  EXPECT_TRUE(scene.ok()) << scene.status();
  return *std::move(scene);
}

int ObjectCount(const SegmentedScene& scene) {
  int count = 0;
  for (const SegmentedHypothesis& hypothesis : scene.hypotheses)
    count += hypothesis.supported_by >= 0;
  return count;
}

// The index of the segmented object with most of a true object's points.
std::size_t HypothesisOf(const SegmentedScene& scene, const SimulatedCloud& truth,
                         std::int32_t object) {
  std::vector<std::size_t> shared;
  for (const SegmentedHypothesis& hypothesis : scene.hypotheses) {
    shared.push_back(static_cast<std::size_t>(std::count_if(
        hypothesis.points.begin(), hypothesis.points.end(),
        [&](std::uint32_t i) { return truth.object[scene.points.cloud_index[i]] == object; })));
  }
  return static_cast<std::size_t>(std::max_element(shared.begin(), shared.end()) - shared.begin());
}

// Intersection over union of a true object with the segmented object that covers it best.
double BestOverlap(const SegmentedScene& scene, const SimulatedCloud& truth, std::int32_t object) {
  double all = 0, best = 0;
  for (std::size_t i = 0; i < truth.cloud.size(); ++i) {
    all += truth.object[i] == object && truth.cloud.points[i].allFinite();
  }
  for (const SegmentedHypothesis& hypothesis : scene.hypotheses) {
    double shared = 0;
    for (std::uint32_t i : hypothesis.points) {
      shared += truth.object[scene.points.cloud_index[i]] == object;
    }
    best = std::max(best, shared / (all + static_cast<double>(hypothesis.points.size()) - shared));
  }
  return best;
}

void ExpectAllFound(const SimulatedScene& simulated) {
  const SimulatedCloud truth = Scan(simulated, SteepCamera(), {});
  const SegmentedScene scene = Segmented(truth.cloud);
  EXPECT_EQ(scene.supports.size(), 1u);
  EXPECT_EQ(ObjectCount(scene), static_cast<int>(simulated.objects.size()) - 1);
  for (std::size_t k = 1; k < simulated.objects.size(); ++k) {
    EXPECT_GT(BestOverlap(scene, truth, static_cast<std::int32_t>(k)), kMinOverlap)
        << simulated.objects[k].name;
  }
}

TEST(SegmentScene, FindsBoxesThatStandApart) {
  ExpectAllFound(Table({BoxAt("left", {0.1, 0.1, 0.15}, {0, 0.2, 0.075}),
                        BoxAt("right", {0.12, 0.08, 0.1}, {0, -0.2, 0.05})}));
}

TEST(SegmentScene, SplitsABoxFromTheTallerOneThatItTouches) {
  ExpectAllFound(Table({BoxAt("back", {0.08, 0.2, 0.2}, {0.1, 0, 0.1}),
                        BoxAt("front", {0.08, 0.1, 0.08}, {0.02, 0, 0.04})}));
}

TEST(SegmentScene, SplitsStackedBoxes) {
  ExpectAllFound(Table({BoxAt("below", {0.2, 0.25, 0.08}, {0, 0, 0.04}),
                        BoxAt("above", {0.08, 0.1, 0.1}, {0.02, 0, 0.13})}));
}

TEST(SegmentScene, JoinsABoxThatAnOccluderCutsInTwo) {
  ExpectAllFound(Table({BoxAt("behind", {0.08, 0.3, 0.08}, {0.15, 0, 0.04}),
                        BoxAt("before", {0.05, 0.08, 0.2}, {-0.05, 0, 0.1})}));
}

// A wall behind the counter that objects in front of it cut apart, and the front of the cabinet
// below.
TEST(SegmentScene, KeepsWallsAndFrontsFromBeingObjects) {
  const SimulatedScene kitchen = KitchenCounter();
  const SimulatedCloud truth = Scan(kitchen, KitchenCamera(), {});
  const SegmentedScene scene = Segmented(truth.cloud);
  int objects = 0;
  for (std::size_t k = 0; k < kitchen.objects.size(); ++k) {
    if (kitchen.objects[k].is_support) continue;
    const bool is_structure =
        kitchen.objects[k].name == "wall" || kitchen.objects[k].name == "cabinet";
    objects += !is_structure;
    const auto object = static_cast<std::int32_t>(k);
    EXPECT_GT(BestOverlap(scene, truth, object), kMinOverlap) << kitchen.objects[k].name;
    EXPECT_EQ(scene.hypotheses[HypothesisOf(scene, truth, object)].supported_by,
              is_structure ? -1 : 0)
        << kitchen.objects[k].name;
  }
  EXPECT_EQ(ObjectCount(scene), objects);
}

TEST(SegmentScene, MeasuresUpAndTheSupportItself) {
  const PinholeCamera camera = SteepCamera();
  const SimulatedCloud truth =
      Scan(Table({BoxAt("box", {0.1, 0.1, 0.1}, {0, 0, 0.05})}), camera, {});
  const SegmentedScene scene = Segmented(truth.cloud);
  const Vector3 up_L = scene.R_LC * camera.X_WC.linear().transpose() * Vector3::UnitZ();
  // The scanner's warp of 1.3 mm over 0.2 m tilts the scene by less than half a degree.
  EXPECT_GT(up_L.z(), std::cos(0.01));
  ASSERT_EQ(scene.supports.size(), 1u);
  const double top = scene.supports[0].plate.X_FS.translation().z();
  EXPECT_NEAR(top, -camera.X_WC.translation().z(), 0.005);
}

TEST(SegmentScene, FindsTheSameObjectsInAShuffledCloud) {
  const SimulatedCloud truth = Scan(Table({BoxAt("left", {0.1, 0.1, 0.15}, {0, 0.2, 0.075}),
                                           BoxAt("right", {0.12, 0.08, 0.1}, {0, -0.2, 0.05})}),
                                    SteepCamera(), {});
  std::vector<std::uint32_t> order(truth.cloud.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  SimulatedCloud shuffled;
  for (std::uint32_t i : order) {
    shuffled.cloud.points.push_back(truth.cloud.points[i]);
    shuffled.object.push_back(truth.object[i]);
  }
  shuffled.cloud.width = static_cast<int>(order.size());
  SegmentOptions options;
  options.up_C = SteepCamera().X_WC.linear().transpose() * Vector3::UnitZ();
  const SegmentedScene scene = Segmented(shuffled.cloud, options);
  EXPECT_EQ(scene.supports.size(), 1u);
  EXPECT_GT(BestOverlap(scene, shuffled, 1), kMinOverlap);
  EXPECT_GT(BestOverlap(scene, shuffled, 2), kMinOverlap);
}

// Invalid normals are estimated anew, as in a cloud without normals.
TEST(SegmentScene, TakesNoNormalsThatAreNotANumberOrOfNoLength) {
  const PointCloud bare =
      Scan(Table({BoxAt("box", {0.1, 0.1, 0.15}, {0, 0.2, 0.075})}), SteepCamera(), {}).cloud;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3f none[] = {Eigen::Vector3f::Zero(), Eigen::Vector3f::Constant(nan),
                                  Eigen::Vector3f(0, nan, 1)};
  PointCloud mixed = bare;
  for (std::size_t i = 0; i < bare.size(); ++i) mixed.normals.push_back(none[i % std::size(none)]);
  for (const bool is_image : {true, false}) {
    PointCloud without = bare, with = mixed;
    if (!is_image) {
      with.width = without.width = static_cast<int>(bare.size());
      with.height = without.height = 1;
    }
    const SegmentedScene a = Segmented(without), b = Segmented(with);
    EXPECT_EQ(a.points.normals, b.points.normals);
    ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
    for (std::size_t k = 0; k < a.hypotheses.size(); ++k)
      EXPECT_EQ(a.hypotheses[k].points, b.hypotheses[k].points);
    EXPECT_EQ(a.supports.size(), 1u);
  }
}

TEST(SegmentScene, IsTheSameOnAnyNumberOfThreads) {
  const SimulatedCloud truth = Scan(KitchenCounter(), KitchenCamera(), {});
  const SegmentedScene a = Segmented(truth.cloud, {}, {.max_threads = 1});
  const SegmentedScene b = Segmented(truth.cloud, {}, {.max_threads = 2});
  EXPECT_EQ(a.points.points, b.points.points);
  EXPECT_EQ(a.points.normals, b.points.normals);
  EXPECT_EQ(a.rejected, b.rejected);
  ASSERT_GE(a.hypotheses.size(), 8u);  // of the counter
  ASSERT_FALSE(a.supports.empty());
  ASSERT_EQ(a.hypotheses.size(), b.hypotheses.size());
  for (std::size_t k = 0; k < a.hypotheses.size(); ++k)
    EXPECT_EQ(a.hypotheses[k].points, b.hypotheses[k].points);
  ASSERT_EQ(a.supports.size(), b.supports.size());
  for (std::size_t k = 0; k < a.supports.size(); ++k) {
    EXPECT_EQ(a.supports[k].plate.shape, b.supports[k].plate.shape);
  }
}

TEST(SegmentScene, StopsWhenAsked) {
  std::stop_source source;
  source.request_stop();
  const SimulatedCloud truth = Scan(Table({}), SteepCamera(), {});
  const auto scene =
      SegmentScene(*CollectMeasured(truth.cloud, {}), {}, {.stop = source.get_token()});
  EXPECT_EQ(scene.status().code(), absl::StatusCode::kCancelled);
}

}  // namespace
}  // namespace cwm::perception
