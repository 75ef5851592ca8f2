#include "perception/segmentation/surface_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include "perception/cloud/normals.h"
#include "perception/segmentation/connected_sets.h"
#include "perception/segmentation/creases.h"

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr int kWidth = 160, kHeight = 120;
constexpr float kFocal_px = 131;  // a quarter of a Kinect's image
constexpr float kCrease_rad = 20 * std::numbers::pi_v<float> / 180;

// Boxes in front of a wall, as rough as a Kinect sees them, with gaps.
MeasuredPoints Blocks(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::uniform_real_distribution<float> uniform(0, 1);
  std::normal_distribution<float> noise(0, 0.0015f);
  PointCloud cloud;
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Vector3f ray((static_cast<float>(u) - 80) / kFocal_px,
                         (static_cast<float>(v) - 60) / kFocal_px, 1);
      const int block = (u / 23 + v / 17) % 3;
      float z = 0.9f - 0.3f * ray.y() + 0.03f * static_cast<float>(block);
      if (block == 1) z -= 0.8f * std::abs(ray.x() - std::round(ray.x() * 6) / 6);
      if (uniform(random) < 0.05f) z = std::nanf("");
      cloud.points.push_back(ray * (z + noise(random)));
    }
  }
  MeasuredPoints measured = *CollectMeasured(cloud, {});
  EstimateImageNormals(measured, {});
  return measured;
}

bool IsFrontal(const OrientedPoints& nodes, std::size_t i) {
  return std::abs(nodes.normals[i].dot(nodes.points[i])) >=
         kSteepIncidence_cos * nodes.points[i].norm();
}

// True if two pixels are linked by the rule that the header states for ForEachLinked.
bool AreLinked(const MeasuredPoints& measured, std::size_t a, std::size_t b) {
  const OrientedPoints& nodes = measured.oriented;
  const float sigma = std::max(nodes.sigma_m[a], nodes.sigma_m[b]);
  const float jump = std::abs(nodes.points[a].norm() - nodes.points[b].norm());
  const Vector3f d = nodes.points[b] - nodes.points[a];
  const bool known_a = !nodes.normals[a].isZero(), known_b = !nodes.normals[b].isZero();
  const float step = std::max(4 * sigma, 1.5f * measured.pixel_angle_rad * nodes.points[a].norm());
  const bool off_a = known_a && std::abs(nodes.normals[a].dot(d)) > step;
  const bool off_b = known_b && std::abs(nodes.normals[b].dot(d)) > step;
  const bool frontal = known_a && known_b && IsFrontal(nodes, a) && IsFrontal(nodes, b);
  if (jump <= MaxJump_m(sigma) && !(frontal ? off_a || off_b : off_a && off_b)) return true;
  return jump <= 3 * MaxJump_m(sigma) && known_a && known_b && !off_a && !off_b;
}

TEST(SurfaceGraph, LinksThePixelsBesideEachOtherOnOneSurfaceInTheirOrder) {
  const MeasuredPoints measured = Blocks(1);
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {.max_threads = 2});
  const OrientedPoints& nodes = measured.oriented;
  std::size_t links = 0, gaps = 0, steps = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const int pixel = static_cast<int>(measured.oriented.cloud_index[i]);
    std::vector<std::size_t> expected, found, before, expected_steps, found_steps;
    for (int v = pixel / kWidth - 1; v <= pixel / kWidth + 1; ++v) {
      for (int u = pixel % kWidth - 1; u <= pixel % kWidth + 1; ++u) {
        if (v < 0 || u < 0 || v >= kHeight || u >= kWidth) continue;
        const std::int32_t other =
            measured.image[static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u)];
        if (other < 0 || static_cast<std::size_t>(other) == i) continue;
        const auto j = static_cast<std::size_t>(other);
        if (AreLinked(measured, i, j)) {
          expected.push_back(j);
          continue;
        }
        ++gaps;
        const float jump = std::abs(nodes.points[i].norm() - nodes.points[j].norm());
        const float sigma = std::max(nodes.sigma_m[i], nodes.sigma_m[j]);
        if (jump <= MaxJump_m(sigma)) expected_steps.push_back(j);
      }
    }
    graph.ForEachLinked(i, [&](std::size_t j) { found.push_back(j); });
    ASSERT_EQ(found, expected) << "node " << i;
    links += found.size();
    graph.ForEachAcrossStep(i, [&](std::size_t j) { found_steps.push_back(j); });
    ASSERT_EQ(found_steps, expected_steps) << "node " << i;
    EXPECT_EQ(graph.IsAtStep(i), !found_steps.empty()) << "node " << i;
    steps += found_steps.size();
    graph.ForEachLinkedBefore(i, [&](std::size_t j) { before.push_back(j); });
    std::erase_if(expected, [&](std::size_t j) { return j > i; });
    ASSERT_EQ(before, expected) << "node " << i;
  }
  EXPECT_GT(links, 6 * graph.size());
  EXPECT_GT(gaps, graph.size() / 20);
  EXPECT_GT(steps, graph.size() / 40);
}

TEST(FindConcaveCreases, AreThoseOfThePairsButForAnglesRightAtTheLimit) {
  const MeasuredPoints measured = Blocks(2);
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  const std::vector<char> creases = FindConcaveCreases(graph, kCrease_rad, {.max_threads = 2});
  constexpr float kRounding_rad = 1e-4f;  // of floats, where the sine's slope is not small
  const std::vector<char> more = FindConcaveCreasesByPairs(graph, kCrease_rad - kRounding_rad, {});
  const std::vector<char> fewer = FindConcaveCreasesByPairs(graph, kCrease_rad + kRounding_rad, {});
  std::size_t count = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    ASSERT_LE(fewer[i], creases[i]) << "node " << i;
    ASSERT_LE(creases[i], more[i]) << "node " << i;
    count += creases[i] != 0;
  }
  EXPECT_GT(count, graph.size() / 50);
  EXPECT_LT(count, graph.size() / 2);
}

TEST(ConnectedSets, HoldWhatCanBeReachedWithinAClassInTheOrderOfFirstNodes) {
  const MeasuredPoints measured = Blocks(3);
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  std::vector<std::int32_t> classes(graph.size());
  std::mt19937 random(4);
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const int pixel = static_cast<int>(measured.oriented.cloud_index[i]);
    classes[i] = random() % 8 == 0 ? -1 : pixel % kWidth / 40 % 2;
  }
  const ConnectedSets sets = FindConnectedSets(graph, classes, {.max_threads = 2});
  std::vector<std::int32_t> expected(graph.size(), kNoIndex);
  std::vector<std::uint32_t> first_nodes;
  for (std::uint32_t start = 0; start < graph.size(); ++start) {
    if (classes[start] < 0 || expected[start] != kNoIndex) continue;
    const auto number = static_cast<std::int32_t>(first_nodes.size());
    first_nodes.push_back(start);
    std::vector<std::size_t> front{start};
    expected[start] = number;
    while (!front.empty()) {
      const std::size_t i = front.back();
      front.pop_back();
      graph.ForEachLinked(i, [&](std::size_t j) {
        if (classes[j] != classes[i] || expected[j] != kNoIndex) return;
        expected[j] = number;
        front.push_back(j);
      });
    }
  }
  EXPECT_EQ(sets.of_node, expected);
  EXPECT_EQ(sets.first_nodes, first_nodes);
  EXPECT_GT(sets.count(), 10u);
  EXPECT_EQ(FindConnectedSets(graph, classes, {}).of_node, sets.of_node);  // on one thread
}

// A wall at 0.8 m whose right half is nearer by `step_m`, at a Kinect's resolution.
MeasuredPoints Step(float step_m) {
  constexpr float kKinect_px = 525;
  PointCloud cloud;
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const Vector3f ray((static_cast<float>(u) - 80) / kKinect_px,
                         (static_cast<float>(v) - 60) / kKinect_px, 1);
      cloud.points.push_back(ray * (u < kWidth / 2 ? 0.8f : 0.8f - step_m));
    }
  }
  MeasuredPoints measured = *CollectMeasured(cloud, {});
  EstimateImageNormals(measured, {});
  return measured;
}

TEST(SurfaceGraph, EndsASurfaceWhereItStepsByMoreThanNoiseThoughByLessThanAJump) {
  const MeasuredPoints measured = Step(0.010f);
  ASSERT_LT(0.010f, MaxJump_m(measured.oriented.sigma_m[0]));
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  std::size_t at_step = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const auto column = static_cast<int>(measured.oriented.cloud_index[i]) % kWidth;
    graph.ForEachLinked(i, [&](std::size_t j) {
      const auto other = static_cast<int>(measured.oriented.cloud_index[j]) % kWidth;
      EXPECT_EQ(column < kWidth / 2, other < kWidth / 2) << "node " << i;
    });
    at_step += graph.IsAtStep(i);
    if (graph.IsAtStep(i)) {
      EXPECT_TRUE(column == kWidth / 2 - 1 || column == kWidth / 2) << column;
    }
  }
  EXPECT_EQ(at_step, 2u * kHeight);
}

TEST(SurfaceGraph, LinksAcrossWhatNoiseExplains) {
  const MeasuredPoints measured = Step(0.002f);
  const SurfaceGraph graph = SurfaceGraph::OfImage(measured, {});
  for (std::size_t i = 0; i < graph.size(); ++i) EXPECT_FALSE(graph.IsAtStep(i)) << "node " << i;
}

}  // namespace
}  // namespace cwm::perception
