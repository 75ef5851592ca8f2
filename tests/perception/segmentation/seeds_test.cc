// Two faces, one behind the other by a step of a few sigma, that are connected through a gap in the
// step.
#include "perception/segmentation/seeds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <vector>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr int kWidth = 90, kHeight = 60;
constexpr float kFocal_px = 525;
constexpr float kBehind_m = 0.8f;
constexpr float kStep_m = 0.012f;  // the graph calls 4 sigma a step, which is 4.4 mm here

// An image with the depth at (row, column), NaN for no return. Every pixel faces the sensor.
MeasuredPoints Image(const std::function<float(int, int)>& depth_m) {
  PointCloud cloud;
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Vector3f ray((static_cast<float>(u) - 45) / kFocal_px,
                         (static_cast<float>(v) - 30) / kFocal_px, 1);
      cloud.points.push_back(ray * depth_m(v, u));
    }
  }
  MeasuredPoints measured = *CollectMeasured(cloud, {});
  for (Vector3f& normal : measured.oriented.normals) normal = -Vector3f::UnitZ();
  return measured;
}

// The seeds of the nodes that are not at a step.
Seeds SeedsOf(const MeasuredPoints& measured) {
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  const std::vector<char> crease(graph.size(), 0);
  std::vector<std::int32_t> classes(graph.size(), 0);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    if (graph.IsAtStep(i)) classes[i] = kNoIndex;
  }
  const Seeds seeds = FindSeeds(graph, crease, classes, {.max_threads = 2});
  EXPECT_EQ(FindSeeds(graph, crease, classes, {}).of_node, seeds.of_node);  // on one thread
  return seeds;
}

// The seed of the node at a pixel that returns.
std::int32_t SeedAt(const Seeds& seeds, const MeasuredPoints& measured, int row, int column) {
  const auto pixel = static_cast<std::size_t>(row) * kWidth + static_cast<std::size_t>(column);
  const std::int32_t node = measured.image[pixel];
  return seeds.of_node[static_cast<std::size_t>(node)];
}

// The right half lies nearer. In `gap` rows from row 20 on, the depth changes evenly from one half
// to the other, by 4 mm per pixel.
float TwoFaces(int row, int column, int gap) {
  if (row < 20 || row >= 20 + gap) return column < 45 ? kBehind_m : kBehind_m - kStep_m;
  const float across = std::clamp(static_cast<float>(column - 43) / 3, 0.0f, 1.0f);
  return kBehind_m - across * kStep_m;
}

class Gap : public testing::TestWithParam<int> {};

TEST_P(Gap, OfAStepLeavesTwoSeeds) {
  const MeasuredPoints measured = Image([](int v, int u) { return TwoFaces(v, u, GetParam()); });
  const Seeds seeds = SeedsOf(measured);
  EXPECT_EQ(seeds.count(), 2u);
  const std::int32_t left = SeedAt(seeds, measured, 30, 10);
  const std::int32_t right = SeedAt(seeds, measured, 30, 80);
  EXPECT_NE(left, right);
  EXPECT_GE(std::min(left, right), 0);
}

INSTANTIATE_TEST_SUITE_P(Rows, Gap, testing::Values(0, 3, 4));

TEST(Seeds, OfOneSurfaceIsOneWhereHalfOfItsBorderIsEven) {
  const MeasuredPoints measured = Image([](int v, int u) { return TwoFaces(v, u, 30); });
  const Seeds seeds = SeedsOf(measured);
  EXPECT_EQ(seeds.count(), 1u);
  EXPECT_EQ(SeedAt(seeds, measured, 30, 10), SeedAt(seeds, measured, 30, 80));
}

// Five pixels wide, with one pixel in the middle that noise moved: the pixels left beside it are
// beside a step as well.
TEST(Seeds, OfAHandleThatNoiseSplitIsOne) {
  const MeasuredPoints measured = Image([](int v, int u) {
    if (v < 28 || v > 32) return std::nanf("");
    return v == 30 && u == 45 ? kBehind_m + kStep_m : kBehind_m;
  });
  const Seeds seeds = SeedsOf(measured);
  EXPECT_EQ(seeds.count(), 1u);
  EXPECT_GE(SeedAt(seeds, measured, 30, 10), 0);
  EXPECT_EQ(SeedAt(seeds, measured, 30, 10), SeedAt(seeds, measured, 30, 80));
  EXPECT_EQ(SeedAt(seeds, measured, 30, 45), kNoIndex);
}

TEST(Seeds, OfNarrowObjectsWithAStepBetweenAreTwo) {
  const MeasuredPoints measured =
      Image([](int v, int u) { return v < 18 || v > 24 ? std::nanf("") : TwoFaces(v, u, 4); });
  const Seeds seeds = SeedsOf(measured);
  EXPECT_EQ(seeds.count(), 2u);
  EXPECT_NE(SeedAt(seeds, measured, 20, 10), SeedAt(seeds, measured, 20, 80));
}

TEST(Seeds, KeepClassesApart) {
  const MeasuredPoints measured = Image([](int, int) { return kBehind_m; });
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  std::vector<std::int32_t> classes(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) classes[i] = i % kWidth < 20 ? 0 : 3;
  const Seeds seeds = FindSeeds(graph, std::vector<char>(graph.size(), 0), classes, {});
  EXPECT_EQ(seeds.classes, (std::vector<std::int32_t>{0, 3}));
}

}  // namespace
}  // namespace cwm::perception
