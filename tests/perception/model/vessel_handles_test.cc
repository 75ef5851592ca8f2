#include "perception/handles/vessel_handles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "perception/cloud/seen_width.h"
#include "tests/perception/model/vessels.h"

namespace cwm::perception {
namespace {

// A mug around the z axis, seen from the side.
class VesselHandles : public ::testing::Test {
 protected:
  VesselHandles() {
    mug_.viewpoint = Vector3(-0.6, 0, 0.6);
    AddMug(Vector2::Zero(), mug_);
    wall_points_ = mug_.size();
  }

  std::vector<Vessel::Cluster> Find() const {
    const std::optional<Vessel> vessel = Vessel::Find(mug_, kSerialWork);
    EXPECT_TRUE(vessel);
    return vessel ? vessel->FindFixedParts(mug_, std::vector<char>(mug_.size(), 1), kSerialWork)
                        .handles
                  : std::vector<Vessel::Cluster>();
  }

  OrientedPoints mug_;
  std::size_t wall_points_ = 0;
};

// A quarter of an ellipse that leads outwards and upwards and is wide where it begins.
void AddSpout(OrientedPoints& points) {
  const auto place = [](double share) {
    const double turn_rad = 0.5 * std::numbers::pi * share;
    return Vector3(0, kMugRadius_m + 0.065 * std::sin(turn_rad),
                   0.05 + 0.05 * (1 - std::cos(turn_rad)));
  };
  for (double share = 0; share < 1; share += 0.05) {
    AddTube({place(share), place(share + 0.05)}, std::lerp(0.032, 0.016, share), points);
  }
}

TEST_F(VesselHandles, FindTheEarButForItsRoots) {
  AddTube(Ear(), 0.01, mug_);
  const auto handles = Find();
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_GE(handles[0].front(), wall_points_);  // no point of the wall
  // Points within 3 sigma of the wall, 4.5 mm of 30, cannot be told from it.
  EXPECT_GT(static_cast<double>(handles[0].size()),
            0.8 * static_cast<double>(mug_.size() - wall_points_));
}

TEST_F(VesselHandles, FindTheBarOfAPan) {
  AddTube({{0, kMugRadius_m, 0.09}, {0, kMugRadius_m + 0.15, 0.11}}, 0.015, mug_);
  EXPECT_EQ(Find().size(), 1u);
}

TEST_F(VesselHandles, AreNoSpouts) {
  AddSpout(mug_);
  EXPECT_TRUE(Find().empty());
}

// As slim as a handle and as high as the mug: its free end shows that it is a spout.
TEST_F(VesselHandles, AreNoSlimSpouts) {
  AddTube({{0, kMugRadius_m, 0.05}, {0, kMugRadius_m + 0.04, 0.06}}, 0.016, mug_);
  AddTube({{0, kMugRadius_m + 0.04, 0.06}, {0, kMugRadius_m + 0.055, 0.1}}, 0.012, mug_);
  EXPECT_TRUE(Find().empty());
}

TEST_F(VesselHandles, AreFoundAmongPointsThatAnotherObjectTook) {
  const std::optional<Vessel> vessel = Vessel::Find(mug_, kSerialWork);
  ASSERT_TRUE(vessel);
  OrientedPoints other;
  other.viewpoint = mug_.viewpoint;
  AddTube(Ear(), 0.01, other);
  const std::size_t of_ear = other.size();
  AddMug(Vector2(0, 0.3), other);  // beside it; its own ear does not count as the first one's
  const auto handles = vessel->FindHandlesIn(other, kSerialWork);
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_LT(handles[0].back(), of_ear);
  EXPECT_NEAR(vessel->Gap_m(other, handles[0]), 0.0, 0.006);  // 3 sigma of the wall, and a spacing
}

TEST_F(VesselHandles, TellWhatLiesOnTheWall) {
  const std::optional<Vessel> vessel = Vessel::Find(mug_, kSerialWork);
  ASSERT_TRUE(vessel);
  std::vector<char> all(mug_.size(), 1);
  EXPECT_GT(vessel->ShareOnWalls(mug_, all), 0.95);
  AddTube(Ear(), 0.01, mug_);
  std::vector<char> ear(mug_.size(), 1);
  std::fill(ear.begin(), ear.begin() + static_cast<std::ptrdiff_t>(wall_points_), char{0});
  EXPECT_LT(vessel->ShareOnWalls(mug_, ear), 0.5);
  EXPECT_EQ(vessel->ShareOnWalls(mug_, std::vector<char>(mug_.size(), 0)), 1);
}

TEST_F(VesselHandles, AreNoBoxesThatTouchTheWall) {
  // A face of 50 x 70 mm that begins at the wall.
  for (double y = kMugRadius_m; y < kMugRadius_m + 0.05; y += 0.002) {
    AddTube({{0, y, 0}, {0, y, 0.07}}, 0.002, mug_);
  }
  EXPECT_TRUE(Find().empty());
}

TEST_F(VesselHandles, AreFoundBesideABoxThatTouchesThem) {
  AddTube(Ear(), 0.01, mug_);
  const std::size_t with_ear = mug_.size();
  for (double y = kMugRadius_m + 0.036; y < kMugRadius_m + 0.1; y += 0.002) {
    AddTube({{0, y, 0}, {0, y, 0.1}}, 0.002, mug_);
  }
  const auto handles = Find();
  ASSERT_EQ(handles.size(), 1u);
  const auto of_box = std::count_if(handles[0].begin(), handles[0].end(),
                                    [&](std::uint32_t i) { return i >= with_ear; });
  EXPECT_LT(static_cast<double>(of_box), 0.3 * static_cast<double>(handles[0].size()));
}

TEST_F(VesselHandles, AreOneAcrossAGap) {
  // Another object hides 15 mm of the bar.
  AddTube({{0, kMugRadius_m, 0.09}, {0, kMugRadius_m + 0.12, 0.11}}, 0.015, mug_);
  AddTube({{0, kMugRadius_m + 0.135, 0.1125}, {0, kMugRadius_m + 0.18, 0.12}}, 0.015, mug_);
  const auto handles = Find();
  ASSERT_EQ(handles.size(), 1u);
  EXPECT_EQ(handles[0].back(), mug_.size() - 1) << "its end is part of it";
}

TEST_F(VesselHandles, AreNotNearerThanAFinger) {
  AddTube({{0, kMugRadius_m + 0.01, 0.02}, {0, kMugRadius_m + 0.01, 0.08}}, 0.01, mug_);
  EXPECT_TRUE(Find().empty());
}

TEST_F(VesselHandles, AreKnownWhenTheyWereCutOff) {
  const std::optional<Vessel> vessel = Vessel::Find(mug_, kSerialWork);
  ASSERT_TRUE(vessel);
  OrientedPoints ear, far_ear, spout;
  ear.viewpoint = far_ear.viewpoint = spout.viewpoint = mug_.viewpoint;
  AddTube(Ear(), 0.01, ear);
  std::vector<Vector3> shifted = Ear();
  for (Vector3& p : shifted) p.y() += 0.1;
  AddTube(shifted, 0.01, far_ear);
  AddSpout(spout);
  EXPECT_TRUE(vessel->HasHandle(ear, {}));
  EXPECT_FALSE(vessel->HasHandle(far_ear, {})) << "no nearer than 100 mm";
  EXPECT_FALSE(vessel->HasHandle(spout, {}));
}

TEST(SeenWidth, OfAStripIsItsWidthHoweverItIsSlanted) {
  for (const double slope : {0.0, 1.0}) {
    for (const double width_m : {0.012, 0.018, 0.03}) {
      std::vector<Eigen::Vector3f> strip;
      for (double x = -0.05; x < 0.05; x += 0.001) {
        for (double y = -0.5 * width_m; y < 0.5 * width_m; y += 0.001) {
          strip.push_back(Vector3(x, y, 1 + slope * x).cast<float>());
        }
      }
      // A disc that is filled by 85 % is 1.35 times as wide as the strip that it juts out of. A
      // spacing of 1 mm on either side is added, and the density falls towards the border of a
      // narrow strip.
      EXPECT_NEAR(SeenWidth_m(strip, Vector3::Zero()), 1.35 * width_m, 0.004)
          << slope << " " << width_m;
      EXPECT_NEAR(SeenPitch_m(strip, Vector3::Zero()), 0.001, 0.0003);
    }
  }
}

TEST(SeenWidth, TellsTheWideEndFromTheSlimOne) {
  // A square of 50 mm with a strip of 10 mm on its side.
  std::vector<Eigen::Vector3f> points;
  for (double x = 0; x < 0.1; x += 0.001) {
    const double width_m = x < 0.05 ? 0.05 : 0.01;
    for (double y = -0.5 * width_m; y < 0.5 * width_m; y += 0.001) {
      points.push_back(Vector3(x, y, 1).cast<float>());
    }
  }
  const std::vector<char> wide = MarkWideParts(points, Vector3::Zero(), 0.03, 0);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p = points[i].cast<double>();
    // Discs jut out of the square a little and miss its corners.
    if (p.x() > 0.065) {
      EXPECT_FALSE(wide[i]) << p.transpose();
    } else if (p.x() > 0.015 && p.x() < 0.035 && std::abs(p.y()) < 0.01) {
      EXPECT_TRUE(wide[i]) << p.transpose();
    }
  }
}

TEST(SeenWidth, OfNothingIsZero) {
  EXPECT_EQ(SeenWidth_m({}, Vector3::Zero()), 0);
  EXPECT_EQ(SeenPitch_m({}, Vector3::Zero()), 0);
}

}  // namespace
}  // namespace cwm::perception
