#include "collision/broadphase/bounds_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cwm::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

Aabb Cube(const Vector3& centre, double half_m) {
  return {centre.array() - half_m, centre.array() + half_m};
}

std::vector<Aabb> RandomBoxes(int count, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-2, 2);
  std::uniform_real_distribution<double> size(0.001, 0.4);
  std::vector<Aabb> boxes;
  for (int i = 0; i < count; ++i) {
    boxes.push_back(Cube({place(random), place(random), place(random)}, size(random)));
  }
  return boxes;
}

// Independent of the tree: the distance of two boxes axis by axis.
double BruteDistance_m(const Aabb& a, const Aabb& b) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    double gap = 0;
    if (a.max()[axis] < b.min()[axis]) gap = b.min()[axis] - a.max()[axis];
    if (b.max()[axis] < a.min()[axis]) gap = a.min()[axis] - b.max()[axis];
    sum += gap * gap;
  }
  return std::sqrt(sum);
}

std::vector<std::uint32_t> Within(const BoundsTree& tree, const Aabb& box, double distance_m) {
  std::vector<std::uint32_t> found;
  tree.ForEachWithin(box, distance_m, [&](std::uint32_t i) { found.push_back(i); });
  return found;
}

TEST(BoundsTree, FindsWhatBruteForceFindsWithinADistance) {
  std::mt19937 random(1);
  for (const int count : {1, 2, 3, 7, 64, 500}) {
    const auto boxes = RandomBoxes(count, random);
    const BoundsTree tree(boxes);
    for (const Aabb& query : RandomBoxes(20, random)) {
      for (const double distance_m : {0.0, 0.1, 1.0}) {
        std::vector<std::uint32_t> expected;
        for (int i = 0; i < count; ++i) {
          if (BruteDistance_m(query, boxes[i]) <= distance_m) expected.push_back(i);
        }
        EXPECT_THAT(Within(tree, query, distance_m), testing::UnorderedElementsAreArray(expected));
      }
    }
  }
}

TEST(BoundsTree, VisitsAllBoxesNearestFirst) {
  std::mt19937 random(2);
  const auto boxes = RandomBoxes(300, random);
  const BoundsTree tree(boxes);
  const Aabb query = Cube({0.3, -0.2, 0.1}, 0.05);
  std::vector<std::pair<double, std::uint32_t>> visited;
  tree.ForEachNearest(query, kInfinity, [&](std::uint32_t i, double bound_m) {
    EXPECT_DOUBLE_EQ(bound_m, BruteDistance_m(query, boxes[i]));
    visited.emplace_back(bound_m, i);
    return kInfinity;
  });
  EXPECT_EQ(visited.size(), boxes.size());
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));  // by distance, then index
}

TEST(BoundsTree, StopsAtTheDistanceThatTheVisitorReturns) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < 10; ++i) boxes.push_back(Cube({1.0 * i, 0, 0}, 0.1));
  const BoundsTree tree(boxes);
  std::vector<std::uint32_t> visited;
  tree.ForEachNearest(Cube({0, 0, 0}, 0.1), kInfinity, [&](std::uint32_t i, double) {
    visited.push_back(i);
    return 2.0;  // box 2 begins at 1.8, box 3 at 2.8
  });
  EXPECT_THAT(visited, ElementsAre(0, 1, 2));
}

TEST(BoundsTree, AVisitorEndsTheWalkByReturningFalse) {
  const std::vector<Aabb> boxes(20, Cube({0, 0, 0}, 1));
  int visits = 0;
  BoundsTree(boxes).ForEachWithin(boxes[0], 0, [&](std::uint32_t) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(BoundsTree, TouchingBoxesCount) {
  const std::vector<Aabb> boxes = {Cube({2, 0, 0}, 1)};
  EXPECT_THAT(Within(BoundsTree(boxes), Cube({0, 0, 0}, 1), 0), ElementsAre(0));
  EXPECT_THAT(Within(BoundsTree(boxes), Cube({-0.001, 0, 0}, 1), 0), IsEmpty());
}

TEST(BoundsTree, HoldsUnboundedBoxesAndLeavesEmptyOnesOut) {
  const Aabb below(Vector3::Constant(-kInfinity), Vector3(kInfinity, kInfinity, 0));
  const std::vector<Aabb> boxes = {Cube({0, 0, 1}, 0.1), below, Aabb()};
  const BoundsTree tree(boxes);
  EXPECT_EQ(tree.size(), 3u);
  EXPECT_THAT(Within(tree, Cube({50, 50, 1}, 0.1), 1.0), ElementsAre(1));
  EXPECT_THAT(Within(tree, Cube({0, 0, 0.5}, 0.5), 0), UnorderedElementsAre(0, 1));
  std::vector<double> bounds;
  tree.ForEachNearest(Cube({9, 0, 2}, 0.5), kInfinity, [&](std::uint32_t, double bound_m) {
    bounds.push_back(bound_m);
    return kInfinity;
  });
  ASSERT_EQ(bounds.size(), 2u);
  EXPECT_DOUBLE_EQ(bounds[0], 1.5);
}

TEST(BoundsTree, AnEmptyTreeFindsNothing) {
  EXPECT_THAT(Within(BoundsTree(), Cube({0, 0, 0}, 1), kInfinity), IsEmpty());
  EXPECT_THAT(Within(BoundsTree(std::vector<Aabb>{Aabb()}), Cube({0, 0, 0}, 1), kInfinity),
              IsEmpty());
}

// Entry by bisection-free reasoning: the largest of the entries into the three slabs.
double BruteEntry_m(const Aabb& box, const Vector3& o, const Vector3& d) {
  double enter = 0;
  double leave = kInfinity;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0) {
      if (o[axis] < box.min()[axis] || o[axis] > box.max()[axis]) return kInfinity;
      continue;
    }
    const double near = ((d[axis] > 0 ? box.min() : box.max())[axis] - o[axis]) / d[axis];
    const double far = ((d[axis] > 0 ? box.max() : box.min())[axis] - o[axis]) / d[axis];
    enter = std::max(enter, near);
    leave = std::min(leave, far);
  }
  return enter <= leave ? enter : kInfinity;
}

TEST(BoundsTree, FindsTheBoxesOnARayInOrderOfEntry) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  const auto boxes = RandomBoxes(200, random);
  const BoundsTree tree(boxes);
  for (int i = 0; i < 100; ++i) {
    const Vector3 origin(normal(random), normal(random), normal(random));
    Vector3 direction = Vector3(normal(random), normal(random), normal(random)).normalized();
    if (i % 4 == 0) direction = Vector3::Unit(i % 3);  // components of exactly 0
    std::vector<double> expected;
    for (const Aabb& box : boxes) {
      const double entry_m = BruteEntry_m(box, origin, direction);
      if (entry_m <= 1.5) expected.push_back(entry_m);
    }
    std::sort(expected.begin(), expected.end());
    std::vector<double> entries;
    tree.ForEachOnRay(origin, direction, 1.5, [&](std::uint32_t, double entry_m) {
      entries.push_back(entry_m);
      return kInfinity;
    });
    ASSERT_EQ(entries.size(), expected.size());
    for (std::size_t k = 0; k < entries.size(); ++k) EXPECT_NEAR(entries[k], expected[k], 1e-12);
  }
}

TEST(BoundsTree, ARayWithoutLimitMissesWhatItMisses) {
  const std::vector<Aabb> boxes = {Cube({5, 0, 0}, 1), Cube({0, 5, 0}, 1)};
  std::vector<std::uint32_t> found;
  BoundsTree(boxes).ForEachOnRay({0, 0, 0}, {1, 0, 0}, kInfinity, [&](std::uint32_t i, double) {
    found.push_back(i);
    return kInfinity;
  });
  EXPECT_THAT(found, ElementsAre(0));
}

}  // namespace
}  // namespace cwm::collision
