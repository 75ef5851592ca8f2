// What a camera sees of boxes from the front and above: their near faces and tops.
#include "perception/scene/resting.h"

#include <gtest/gtest.h>

#include <numeric>

namespace cwm::perception {
namespace {

constexpr double kStep_m = 0.004;
constexpr float kSigma_m = 0.0015f;

// Depth runs along x, away from the camera.
struct SeenBox {
  Vector3 low, high;
  bool top_seen = true;
  double seen_from_m = 0;  // what is nearer to the support is hidden
};

class Resting {
 public:
  Resting& Add(const SeenBox& box) {
    Segment segment;
    segment.supported_by = 0;
    const auto put = [&](double x, double y, double z) {
      if (z < box.seen_from_m) return;
      segment.nodes.push_back(static_cast<std::uint32_t>(nodes_.size()));
      nodes_.points.push_back(Vector3(x, y, z).cast<float>());
      nodes_.sigma_m.push_back(kSigma_m);
    };
    for (double y = box.low.y(); y <= box.high.y(); y += kStep_m) {
      for (double z = box.low.z(); z <= box.high.z(); z += kStep_m) put(box.low.x(), y, z);
      for (double x = box.low.x(); x <= box.high.x() && box.top_seen; x += kStep_m) {
        put(x, y, box.high.z());
      }
    }
    segments_.push_back(std::move(segment));
    return *this;
  }

  std::vector<int> Find() {
    const std::vector<Placed<Plate>> plates(1);  // z = 0 is the table's top
    FindWhatTheyRestOn(nodes_, plates, segments_);
    std::vector<int> rests_on;
    for (const Segment& segment : segments_) rests_on.push_back(segment.rests_on);
    return rests_on;
  }
  const std::vector<Segment>& segments() const { return segments_; }

 private:
  OrientedPoints nodes_;
  std::vector<Segment> segments_;
};

using Found = std::vector<int>;

TEST(FindWhatTheyRestOn, ASmallBoxOnALargeOne) {
  Resting scene;
  scene.Add({{0, 0, 0}, {0.2, 0.25, 0.08}}).Add({{0.05, 0.05, 0.08}, {0.13, 0.15, 0.18}});
  EXPECT_EQ(scene.Find(), (Found{-1, 0}));
  // The foot is known to the lowest fiftieth of the nodes, here 3 mm of a face.
  EXPECT_NEAR(scene.segments()[1].foot_height_m, 0.08, 0.01);
}

TEST(FindWhatTheyRestOn, AStackOfEqualBoxesThatHideEachOthersTops) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.1, 0.2, 0.08}, false})
                .Add({{0, 0, 0.08}, {0.1, 0.2, 0.16}, false})
                .Add({{0, 0, 0.16}, {0.1, 0.2, 0.24}})
                .Find(),
            (Found{-1, 0, 1}));
}

TEST(FindWhatTheyRestOn, ALargeBoxThatOverhangsASmallOne) {
  EXPECT_EQ(Resting()
                .Add({{0.06, 0.08, 0}, {0.14, 0.16, 0.08}, false})
                .Add({{0, 0, 0.08}, {0.2, 0.25, 0.14}})
                .Find(),
            (Found{-1, 0}));
}

TEST(FindWhatTheyRestOn, NotWhatStandsOnTheTableBehindALowerBoxThatItTouches) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.08, 0.1, 0.08}})
                .Add({{0.08, 0, 0}, {0.16, 0.2, 0.2}, true, 0.08})
                .Find(),
            (Found{-1, -1}));
}

TEST(FindWhatTheyRestOn, NotWhatStandsFarBehindWhatHidesItsFoot) {
  EXPECT_EQ(Resting()
                .Add({{0, 0, 0}, {0.05, 0.1, 0.1}})
                .Add({{0.2, 0, 0}, {0.3, 0.1, 0.2}, true, 0.1})
                .Find(),
            (Found{-1, -1}));
}

TEST(FindWhatTheyRestOn, NotBoxesSideBySideOnTheTable) {
  EXPECT_EQ(Resting().Add({{0, 0, 0}, {0.1, 0.1, 0.1}}).Add({{0, 0.1, 0}, {0.1, 0.2, 0.1}}).Find(),
            (Found{-1, -1}));
}

}  // namespace
}  // namespace cwm::perception
