#include "collision/broadphase/bounds_tree.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace cwm::collision {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// An item of the trees in this file: a box and an index, which breaks ties.
struct Item {
  std::uint32_t index;
  Aabb box;
};
const Aabb& BoundsOf(const Item& item) { return item.box; }
bool Precedes(const Item& a, const Item& b) { return a.index < b.index; }
std::uint64_t SaltOf(const Item& item) { return 0x9e3779b97f4a7c15 * (item.index + 1); }

// A tree and the items that it refers to.
struct Forest {
  explicit Forest(const std::vector<Aabb>& boxes) {
    for (std::uint32_t i = 0; i < boxes.size(); ++i) items.push_back({i, boxes[i]});
    for (const Item& item : items) pointers.push_back(&item);
    tree = BoundsTree<Item>(pointers);
  }
  Forest(const Forest&) = delete;
  Forest& operator=(const Forest&) = delete;

  std::vector<Item> items;
  std::vector<const Item*> pointers;
  BoundsTree<Item> tree;
};

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::UnorderedElementsAre;

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

// The distance of two boxes axis by axis, independent of the tree.
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

std::vector<std::uint32_t> Within(const BoundsTree<Item>& tree, const Aabb& box,
                                  double distance_m) {
  std::vector<std::uint32_t> found;
  tree.ForEachWithin(box, distance_m, [&](const Item& item) { found.push_back(item.index); });
  return found;
}

TEST(BoundsTree, FindsWhatBruteForceFindsWithinADistance) {
  std::mt19937 random(1);
  for (const int count : {1, 2, 3, 7, 64, 500}) {
    const auto boxes = RandomBoxes(count, random);
    const Forest forest(boxes);
    const BoundsTree<Item>& tree = forest.tree;
    for (const Aabb& query : RandomBoxes(20, random)) {
      for (const double distance_m : {0.0, 0.1, 1.0}) {
        std::vector<std::uint32_t> expected;
        for (int i = 0; i < count; ++i) {
          if (BruteDistance_m(query, boxes[i]) <= distance_m) expected.push_back(i);
        }
        EXPECT_THAT(Within(tree, query, distance_m),
                    ::testing::UnorderedElementsAreArray(expected));
      }
    }
  }
}

TEST(BoundsTree, VisitsAllBoxesNearestFirst) {
  std::mt19937 random(2);
  const auto boxes = RandomBoxes(300, random);
  const Forest forest(boxes);
  const BoundsTree<Item>& tree = forest.tree;
  const Aabb query = Cube({0.3, -0.2, 0.1}, 0.05);
  std::vector<std::pair<double, std::uint32_t>> visited;
  tree.ForEachNearest(query, kInfinity, [&](const Item& item, double bound_m) {
    EXPECT_DOUBLE_EQ(bound_m, BruteDistance_m(query, item.box));
    visited.emplace_back(bound_m, item.index);
    return kInfinity;
  });
  EXPECT_EQ(visited.size(), boxes.size());
  EXPECT_TRUE(std::is_sorted(visited.begin(), visited.end()));  // by distance, then index
}

TEST(BoundsTree, StopsAtTheDistanceThatTheVisitorReturns) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < 10; ++i) boxes.push_back(Cube({1.0 * i, 0, 0}, 0.1));
  const Forest forest(boxes);
  const BoundsTree<Item>& tree = forest.tree;
  std::vector<std::uint32_t> visited;
  tree.ForEachNearest(Cube({0, 0, 0}, 0.1), kInfinity, [&](const Item& item, double) {
    visited.push_back(item.index);
    return 2.0;  // box 2 begins at 1.8, box 3 at 2.8
  });
  EXPECT_THAT(visited, ElementsAre(0, 1, 2));
}

TEST(BoundsTree, AVisitorEndsTheWalkByReturningFalse) {
  const std::vector<Aabb> boxes(20, Cube({0, 0, 0}, 1));
  int visits = 0;
  Forest(boxes).tree.ForEachWithin(boxes[0], 0, [&](const Item&) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(BoundsTree, TouchingBoxesCount) {
  const std::vector<Aabb> boxes = {Cube({2, 0, 0}, 1)};
  EXPECT_THAT(Within(Forest(boxes).tree, Cube({0, 0, 0}, 1), 0), ElementsAre(0));
  EXPECT_THAT(Within(Forest(boxes).tree, Cube({-0.001, 0, 0}, 1), 0), IsEmpty());
}

TEST(BoundsTree, HoldsUnboundedBoxesAndLeavesEmptyOnesOut) {
  const Aabb below(Vector3::Constant(-kInfinity), Vector3(kInfinity, kInfinity, 0));
  const std::vector<Aabb> boxes = {Cube({0, 0, 1}, 0.1), below, Aabb()};
  const Forest forest(boxes);
  const BoundsTree<Item>& tree = forest.tree;
  EXPECT_THAT(Within(tree, Cube({50, 50, 1}, 0.1), 1.0), ElementsAre(1));
  EXPECT_THAT(Within(tree, Cube({0, 0, 0.5}, 0.5), 0), UnorderedElementsAre(0, 1));
  std::vector<double> bounds;
  tree.ForEachNearest(Cube({9, 0, 2}, 0.5), kInfinity, [&](const Item&, double bound_m) {
    bounds.push_back(bound_m);
    return kInfinity;
  });
  ASSERT_EQ(bounds.size(), 2u);
  EXPECT_DOUBLE_EQ(bounds[0], 1.5);
}

TEST(BoundsTree, AnEmptyTreeFindsNothing) {
  EXPECT_THAT(Within(BoundsTree<Item>(), Cube({0, 0, 0}, 1), kInfinity), IsEmpty());
  EXPECT_THAT(Within(Forest({Aabb()}).tree, Cube({0, 0, 0}, 1), kInfinity), IsEmpty());
}

// The length at which a ray enters a box: the largest entry into its three slabs.
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
  const Forest forest(boxes);
  const BoundsTree<Item>& tree = forest.tree;
  for (int i = 0; i < 100; ++i) {
    const Vector3 origin{normal(random), normal(random), normal(random)};
    Vector3 direction = Vector3{normal(random), normal(random), normal(random)}.normalized();
    if (i % 4 == 0) direction = Vector3::Unit(i % 3);  // components of exactly 0
    std::vector<double> expected;
    for (const Aabb& box : boxes) {
      const double entry_m = BruteEntry_m(box, origin, direction);
      if (entry_m <= 1.5) expected.push_back(entry_m);
    }
    std::sort(expected.begin(), expected.end());
    std::vector<double> entries;
    tree.ForEachOnRay(origin, direction, 1.5, [&](const Item&, double entry_m) {
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
  Forest(boxes).tree.ForEachOnRay({0, 0, 0}, {1, 0, 0}, kInfinity, [&](const Item& item, double) {
    found.push_back(item.index);
    return kInfinity;
  });
  EXPECT_THAT(found, ElementsAre(0));
}

// All items in the order of a walk over everything, which shows the shape of the tree.
std::vector<std::uint32_t> Order(const BoundsTree<Item>& tree) {
  return Within(tree, Cube({0, 0, 0}, 1), kInfinity);
}

TEST(BoundsTree, IsTheSameTreeWhateverTheOrderOfInsertionAndRemoval) {
  std::mt19937 random(4);
  auto boxes = RandomBoxes(300, random);
  for (int i = 0; i < 40; ++i) boxes.push_back(boxes[0]);  // one centre: the salt separates them
  const Forest forest(boxes);
  const std::vector<std::uint32_t> order = Order(forest.tree);
  ASSERT_EQ(order.size(), boxes.size());
  for (int round = 0; round < 5; ++round) {
    auto shuffled = forest.pointers;
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    BoundsTree<Item> tree;
    for (const Item* item : shuffled) tree = tree.With(*item);
    EXPECT_EQ(Order(tree), order);
    std::shuffle(shuffled.begin(), shuffled.end(), random);
    for (int i = 0; i < 150; ++i) tree = tree.Without(*shuffled[i]);
    const std::vector<const Item*> rest(shuffled.begin() + 150, shuffled.end());
    EXPECT_EQ(Order(tree), Order(BoundsTree<Item>(rest)));
    for (const Item* item : rest) tree = tree.Without(*item);
    EXPECT_THAT(Order(tree), IsEmpty());
  }
}

TEST(BoundsTree, AChangeSharesAllButAPathAndLeavesTheOldTreeAsItWas) {
  std::mt19937 random(5);
  for (const int count : {100, 1'000, 10'000}) {
    const Forest forest(RandomBoxes(count, random));
    const std::vector<std::uint32_t> before = Order(forest.tree);
    const Item moved{7, Cube({1.5, -1.5, 0.5}, 0.05)};
    const BoundsTree<Item> after = forest.tree.Without(forest.items[7]).With(moved);
    // Two paths of a tree of count / 4 leaves, at most twice as deep as a balanced one.
    EXPECT_LE(after.CountUnsharedNodes(forest.tree), 4 * std::log2(count / 4.0)) << count;
    EXPECT_EQ(Order(forest.tree), before);
  }
}

TEST(BoundsTree, AnUnboundedBoxComesAndGoes) {
  const Forest forest({Cube({0, 0, 1}, 0.1),
                       Aabb(Vector3::Constant(-kInfinity), Vector3(kInfinity, kInfinity, 0))});
  const BoundsTree<Item> without = forest.tree.Without(forest.items[1]);
  EXPECT_THAT(Within(without, Cube({50, 50, 1}, 0.1), 1.0), IsEmpty());
  EXPECT_THAT(Within(without.With(forest.items[1]), Cube({50, 50, 1}, 0.1), 1.0), ElementsAre(1));
}

TEST(MortonCode, TellsTheFirstBitInWhichTwoPlacesDiffer) {
  const MortonCode a = KeyOf(Cube({0.5, 0.5, 0.5}, 0.1), 3),
                   b = KeyOf(Cube({0.5, 0.5, 0.5}, 0.2), 3);
  EXPECT_EQ(FirstDifference(a, b), -1);  // the same centre, whatever the size
  EXPECT_EQ(FirstDifference(a, KeyOf(Cube({0.5, 0.5, 0.5}, 0.1), 2)), 0);
  const int far = FirstDifference(a, KeyOf(Cube({-0.5, 0.5, 0.5}, 0.1), 3));
  const int near = FirstDifference(a, KeyOf(Cube({0.501, 0.5, 0.5}, 0.1), 3));
  EXPECT_GT(far, near);
  EXPECT_GT(near, 63);
  EXPECT_TRUE(BitAt(a, far));  // of the larger coordinate
  EXPECT_FALSE(BitAt(KeyOf(Cube({-0.5, 0.5, 0.5}, 0.1), 3), far));
}

}  // namespace
}  // namespace cwm::collision
