// Localised sampling (section V of the paper): the octree cells from which the search draws its
// samples.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "perception/search/shape_search.h"

namespace cwm::perception {
namespace {

constexpr int kDraws = 20000;

// Points spread evenly over a square of 30 cm.
ModelPoints Square(std::size_t count) {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> draw(0, 0.3f);
  OrientedPoints points;
  points.viewpoint = Vector3(0, 0, 1);
  for (std::uint32_t i = 0; i < count; ++i) {
    points.points.push_back({draw(random), draw(random), 0});
    points.normals.push_back(Eigen::Vector3f::UnitZ());
    points.sigma_m.push_back(0.001f);
    points.normal_sigma_rad.push_back(0.02f);
    points.cloud_index.push_back(i);
  }
  return SubsampleForSearch(points, count);
}

class DrawingSamples : public ::testing::Test {
 protected:
  const ModelPoints points_ = Square(4000);
  const Octree octree_{points_};
  std::vector<char> available_ = std::vector<char>(points_.size(), 1);
  std::mt19937_64 random_{7};

  int LevelOf(std::uint32_t cell) const {  // 0 is the root
    int level = 0;
    while (octree_.nodes()[cell].parent != Octree::kNone) {
      cell = octree_.nodes()[cell].parent;
      ++level;
    }
    return level;
  }
};

TEST_F(DrawingSamples, TakesFourDifferentAvailablePointsOfOneCell) {
  for (std::size_t i = 0; i < available_.size(); i += 3) available_[i] = 0;
  int found = 0;
  for (int k = 0; k < kDraws; ++k) {
    const auto sample = DrawSample(octree_, available_, random_);
    if (!sample) continue;
    ++found;
    const Octree::Node& cell = octree_.nodes()[sample->cell];
    for (const std::uint32_t point : sample->points) {
      ASSERT_TRUE(available_[point]);
      ASSERT_GE(point, cell.begin);
      ASSERT_LT(point, cell.end);
    }
    ASSERT_EQ(std::set(sample->points.begin(), sample->points.end()).size(), 4u);
  }
  EXPECT_GT(found, kDraws / 2);
}

// Shapes of every size are sampled: small cells contain a small one, the root a large one.
TEST_F(DrawingSamples, TakesCellsOfEveryLevelEquallyOften) {
  std::map<int, int> drawn_at;
  std::map<int, double> expected_at;
  for (int k = 0; k < kDraws; ++k) {
    const auto sample = DrawSample(octree_, available_, random_);
    if (sample) ++drawn_at[LevelOf(sample->cell)];
  }
  // Each draw takes one of the levels around a random point, from the smallest cell of four points
  // to the root.
  for (std::uint32_t point = 0; point < points_.size(); ++point) {
    std::uint32_t smallest = octree_.LeafOf(point);
    const auto count = [&] {
      return octree_.nodes()[smallest].end - octree_.nodes()[smallest].begin;
    };
    while (count() < 4) smallest = octree_.nodes()[smallest].parent;
    const int levels = LevelOf(smallest) + 1;
    for (int level = 0; level < levels; ++level) {
      expected_at[level] += 1.0 / levels * kDraws / static_cast<double>(points_.size());
    }
  }
  ASSERT_GE(expected_at.size(), 4u);
  for (const auto& [level, expected] : expected_at) {
    // Draws in the smallest cells often fail, because four different ones of their few points are
    // rarely found.
    const double lost = level + 2 >= static_cast<int>(expected_at.size()) ? 0.3 * expected : 0;
    EXPECT_NEAR(drawn_at[level], expected, 4 * std::sqrt(expected) + lost) << level;
  }
}

TEST_F(DrawingSamples, FindsNothingWhereTooFewAreAvailable) {
  std::fill(available_.begin(), available_.end(), 0);
  available_[100] = available_[2000] = available_[3000] = 1;
  for (int k = 0; k < 200; ++k) EXPECT_FALSE(DrawSample(octree_, available_, random_).has_value());
}

}  // namespace
}  // namespace cwm::perception
