// Boxes seen by a camera in front of them and above: their near faces and tops.
#include "perception/segmentation/resting.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cwm::perception {
namespace {

constexpr double kStep_m = 0.004;
constexpr float kSigma_m = 0.0015f;

// A box with depth along x, away from the camera.
struct SeenBox {
  Vector3 low, high;
  bool top_seen = true;
  double seen_from_m = 0;  // below this height the box is hidden
};

class Resting {
 public:
  Resting& Add(const SeenBox& box) {
    segments_.push_back({.nodes = NodesOf(box), .supported_by = 0});
    return *this;
  }
  // Adds a box under whose foot the camera sees: no support carries it.
  Resting& AddHanging(const SeenBox& box) {
    hanging_.push_back({.nodes = NodesOf(box)});
    return *this;
  }

  std::vector<int> Find() {
    AssignResting(nodes_, table_, nullptr, segments_, kSerialWork);
    std::vector<int> rests_on;
    for (const Segment& segment : segments_) rests_on.push_back(segment.rests_on);
    return rests_on;
  }
  std::vector<int> SupportsOfHanging() {
    AssignSupportsUnderStacks(nodes_, table_, nullptr, segments_, hanging_, kSerialWork);
    std::vector<int> supports;
    for (const Segment& region : hanging_) supports.push_back(region.supported_by);
    return supports;
  }
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  std::vector<std::uint32_t> NodesOf(const SeenBox& box) {
    std::vector<std::uint32_t> nodes;
    const auto put = [&](double x, double y, double z, const Vector3& normal) {
      if (z < box.seen_from_m) return;
      nodes.push_back(static_cast<std::uint32_t>(nodes_.size()));
      nodes_.points.push_back(Vector3(x, y, z).cast<float>());
      nodes_.normals.push_back(normal.cast<float>());
      nodes_.sigma_m.push_back(kSigma_m);
    };
    for (double y = box.low.y(); y <= box.high.y(); y += kStep_m) {
      for (double z = box.low.z(); z <= box.high.z(); z += kStep_m)
        put(box.low.x(), y, z, -Vector3::UnitX());
      for (double x = box.low.x(); x <= box.high.x() && box.top_seen; x += kStep_m) {
        put(x, y, box.high.z(), Vector3::UnitZ());
      }
    }
    return nodes;
  }

  OrientedPoints nodes_;
  std::vector<Placed<Plate>> table_ = std::vector<Placed<Plate>>(1);  // its top is z = 0
  std::vector<Segment> segments_;
  std::vector<Segment> hanging_;
};

using Found = std::vector<int>;

TEST(AssignResting, ASmallBoxOnALargeOne) {
  Resting scene;
  scene.Add({{0, 0, 0}, {0.2, 0.25, 0.08}}).Add({{0.05, 0.05, 0.08}, {0.13, 0.15, 0.18}});
  EXPECT_EQ(scene.Find(), (Found{-1, 0}));
  // The foot is known to the lowest fiftieth of the nodes, here 3 mm of a face.
  EXPECT_NEAR(scene.segments()[1].foot_height_m, 0.08, 0.01);
}

// A crease removes the lowest nodes of the upper box.
TEST(AssignResting, AtTheHeightOfTheFaceBelow) {
  Resting stack;
  stack.Add({{0, 0, 0}, {0.2, 0.25, 0.08}})
      .Add({.low = {0.06, 0.08, 0.08}, .high = {0.14, 0.17, 0.2}, .seen_from_m = 0.09});
  ASSERT_EQ(stack.Find(), (Found{-1, 0}));
  EXPECT_NEAR(stack.segments()[1].foot_height_m, 0.08, 1e-6);
}

TEST(AssignResting, AStackOfEqualBoxesThatHideEachOthersTops) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.1, 0.2, 0.08}, false})
                .Add({{0, 0, 0.08}, {0.1, 0.2, 0.16}, false})
                .Add({{0, 0, 0.16}, {0.1, 0.2, 0.24}})
                .Find(),
            (Found{-1, 0, 1}));
}

TEST(AssignResting, ALargeBoxThatOverhangsASmallOne) {
  EXPECT_EQ(Resting()
                .Add({{0.06, 0.08, 0}, {0.14, 0.16, 0.08}, false})
                .Add({{0, 0, 0.08}, {0.2, 0.25, 0.14}})
                .Find(),
            (Found{-1, 0}));
}

TEST(AssignResting, NotWhatStandsOnTheTableBehindALowerBoxThatItTouches) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.08, 0.1, 0.08}})
                .Add({{0.08, 0, 0}, {0.16, 0.2, 0.2}, true, 0.08})
                .Find(),
            (Found{-1, -1}));
}

TEST(AssignResting, NotWhatStandsFarBehindWhatHidesItsFoot) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.05, 0.1, 0.1}})
                .Add({{0.2, 0, 0}, {0.3, 0.1, 0.2}, true, 0.1})
                .Find(),
            (Found{-1, -1}));
}

TEST(AssignResting, NotBoxesSideBySideOnTheTable) {
  EXPECT_EQ(Resting().Add({{0, 0, 0}, {0.1, 0.1, 0.1}}).Add({{0, 0.1, 0}, {0.1, 0.2, 0.1}}).Find(),
            (Found{-1, -1}));
}

TEST(AssignSupportsUnderStacks, OfABoxAcrossALowerOne) {
  EXPECT_EQ(Resting()
                .Add({{0.06, 0, 0}, {0.14, 0.3, 0.06}})
                .AddHanging({{0, 0.1, 0.06}, {0.2, 0.2, 0.1}})
                .SupportsOfHanging(),
            (Found{0}));
}

TEST(AssignSupportsUnderStacks, OfWhatRestsOnWhatHangsItself) {
  EXPECT_EQ(Resting()
                .Add({{0.06, 0, 0}, {0.14, 0.3, 0.06}})
                .AddHanging({{0.04, 0.12, 0.1}, {0.16, 0.18, 0.16}})
                .AddHanging({{0, 0.1, 0.06}, {0.2, 0.2, 0.1}})
                .SupportsOfHanging(),
            (Found{0, 0}));
}

TEST(AssignSupportsUnderStacks, NoneOfWhatHangsHigherOrBesides) {
  EXPECT_EQ(Resting()
                .Add({{0.06, 0, 0}, {0.14, 0.3, 0.06}})
                .AddHanging({{0, 0.1, 0.12}, {0.2, 0.2, 0.16}})
                .AddHanging({{0, 0.4, 0.06}, {0.2, 0.5, 0.1}})
                .SupportsOfHanging(),
            (Found{-1, -1}));
}

}  // namespace
}  // namespace cwm::perception
