// Supports of the virtual scanner's scenes: the places that their plates cover and those that they
// leave out.
#include "perception/segmentation/support_polygon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include "perception/segmentation/outline_tracing.h"
#include "perception/segmentation/segment_scene.h"
#include "perception/simulation/virtual_scanner.h"

namespace cwm::perception {
namespace {

constexpr double kTop_m = 0.9;
constexpr double kHeightError_m = 0.01;  // more than 5 sigma at 1.2 m; no two tops are nearer

Polygon Rectangle(const Vector2& low, const Vector2& high) {
  return {low, {high.x(), low.y()}, high, {low.x(), high.y()}};
}

SimulatedObject Slab(Polygon outline, double top_m = kTop_m, std::vector<Polygon> holes = {}) {
  return {.name = "slab",
          .parts = {{.shape = Plate{std::move(outline), std::move(holes), 0.03}}},
          .X_WO = MakeTranslation(0, 0, top_m),
          .is_support = true};
}

SimulatedObject Block(const Vector3& size_m, const Vector3& middle_m) {
  return {.name = "block",
          .parts = {{.shape = Box{size_m}}},
          .X_WO = MakeTranslation(middle_m.x(), middle_m.y(), middle_m.z())};
}

// A camera 0.85 m above the top and 0.75 m in front of its middle; x of the image points to the
// world's -y.
PinholeCamera Camera() {
  PinholeCamera camera;
  const Vector3 forward = Vector3(0.75, 0, -0.85).normalized(), right(0, -1, 0);
  camera.X_WC.linear() << right, forward.cross(right), forward;
  camera.X_WC.translation() = Vector3(-0.75, 0, kTop_m + 0.85);
  return camera;
}

SimulatedCloud ScanOf(std::vector<SimulatedObject> objects) {
  objects.push_back({.name = "floor", .parts = {{.shape = HalfSpace{}}}, .is_support = true});
  return Scan({std::move(objects)}, Camera(), {});
}

class SupportsOf {
 public:
  explicit SupportsOf(const PointCloud& cloud) {
    SegmentOptions options;
    options.R_LC = Camera().X_WC.linear();
    auto scene = SegmentScene(*CollectMeasured(cloud, {}), options);
    EXPECT_TRUE(scene.ok()) << scene.status();
    scene_ = *std::move(scene);
  }

  const SegmentedScene& scene() const { return scene_; }

  std::vector<Placed<Plate>> At(double height_m) const {
    std::vector<Placed<Plate>> some;
    for (const SegmentedSupport& support : scene_.supports) {
      const double top = support.plate.X_FS.translation().z() + Camera().X_WC.translation().z();
      if (std::abs(top - height_m) < kHeightError_m) some.push_back(support.plate);
    }
    return some;
  }

  // The distance of a place in a top from the nearest plate of that height; 0 or less on the plate.
  double Outside_m(const Vector2& place, double height_m = kTop_m) const {
    const Vector3 p_L = Vector3(place.x(), place.y(), height_m) - Camera().X_WC.translation();
    double outside = std::numeric_limits<double>::infinity();
    for (const auto& plate : At(height_m))
      outside = std::min(outside, OutsideOutline_m(plate, p_L));
    return outside;
  }

 private:
  SegmentedScene scene_;
};

// One and a half cells of 7.5 mm, plus the blur by lateral noise and mixed pixels.
constexpr double kBorderError_m = 0.02;

const Polygon kLShape = {{-0.35, -0.4}, {0.4, -0.4}, {0.4, 0},
                         {0.05, 0},     {0.05, 0.4}, {-0.35, 0.4}};

TEST(SupportPolygon, OfAnLShapedCounterIsLShaped) {
  const SupportsOf supports(ScanOf({Slab(kLShape)}).cloud);
  ASSERT_EQ(supports.At(kTop_m).size(), 1u);
  EXPECT_GT(supports.Outside_m({0.225, 0.2}), 0.175 - kBorderError_m);  // the notch's middle
  for (const Vector2& place : {Vector2(0.2, -0.2), Vector2(-0.15, 0.2), Vector2(-0.15, -0.2)}) {
    EXPECT_LT(supports.Outside_m(place), -0.15 + kBorderError_m) << place.transpose();
  }
  EXPECT_GT(supports.Outside_m({0.05 + kBorderError_m, 0.2}), 0);
  EXPECT_LT(supports.Outside_m({0.05 - kBorderError_m, 0.2}), 0);
  EXPECT_LE(supports.At(kTop_m)[0].shape.outline.size(), kMaxOutlineCorners);
}

TEST(SupportPolygon, OfAConvexTableIsConvex) {
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.3, -0.4}, {0.3, 0.4}))}).cloud);
  ASSERT_EQ(supports.At(kTop_m).size(), 1u);
  const Plate plate = supports.At(kTop_m)[0].shape;
  EXPECT_TRUE(plate.holes.empty());
  EXPECT_EQ(ConvexHull(plate.outline).size(), plate.outline.size());
  EXPECT_NEAR(SignedArea_m2(plate.outline), 0.6 * 0.8, 2 * (0.6 + 0.8) * kBorderError_m);
}

TEST(SupportPolygon, LeavesTwoTablesWithAVisibleGapTwo) {
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.3, -0.5}, {0.3, -0.04})),
                                    Slab(Rectangle({-0.3, 0.04}, {0.3, 0.5}))})
                                .cloud);
  EXPECT_EQ(supports.At(kTop_m).size(), 2u);
  EXPECT_GT(supports.Outside_m({0, 0}), 0.04 - kBorderError_m);
  EXPECT_LT(supports.Outside_m({0, 0.2}), 0);
  EXPECT_LT(supports.Outside_m({0, -0.2}), 0);
}

// A pole at the near border hides a strip of the table as far as the opposite border.
SimulatedObject Pole() { return Block({0.08, 0.1, 0.65}, {-0.34, 0, kTop_m + 0.325}); }

TEST(SupportPolygon, JoinsATableThatAnObjectCutsInTwo) {
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.35, -0.4}, {0.25, 0.4})), Pole()}).cloud);
  EXPECT_EQ(supports.At(kTop_m).size(), 1u);
  for (double x = -0.3; x <= 0.2; x += 0.1) EXPECT_LT(supports.Outside_m({x, 0}), 0) << x;
}

TEST(SupportPolygon, JoinsATableWhoseMiddleReturnsNothing) {
  SimulatedCloud scan = ScanOf({Slab(Rectangle({-0.35, -0.4}, {0.25, 0.4}))});
  for (std::size_t i = 0; i < scan.cloud.size(); ++i) {
    const Vector3 p_W = Camera().X_WC * scan.cloud.points[i].cast<double>();
    // A shiny strip that mirrors the ceiling, which is out of range.
    if (scan.object[i] == 0 && std::abs(p_W.y()) < 0.06) {
      scan.cloud.points[i].setConstant(std::numeric_limits<float>::quiet_NaN());
    }
  }
  const SupportsOf supports(scan.cloud);
  EXPECT_EQ(supports.At(kTop_m).size(), 1u);
  EXPECT_LT(supports.Outside_m({0, 0}), 0);
}

TEST(SupportPolygon, HasTheHoleThatTheFloorIsSeenThrough) {
  const Polygon hole = Rectangle({-0.1, -0.15}, {0.15, 0.15});
  const SupportsOf supports(
      ScanOf({Slab(Rectangle({-0.35, -0.4}, {0.35, 0.4}), kTop_m, {hole})}).cloud);
  ASSERT_EQ(supports.At(kTop_m).size(), 1u);
  ASSERT_EQ(supports.At(kTop_m)[0].shape.holes.size(), 1u);
  // The measured place is near the hole's near wall, which is 3 cm high: the floor right behind
  // that is hidden.
  EXPECT_GT(supports.Outside_m({0.05, 0}), 0.1 - 0.03 - kBorderError_m);
  for (const Vector2& place :
       {Vector2(-0.2, 0), Vector2(0.25, 0), Vector2(0, 0.3), Vector2(0, -0.3)}) {
    EXPECT_LT(supports.Outside_m(place), 0) << place.transpose();
  }
}

TEST(SupportPolygon, HoldsWhatStandsOnTheTableAndItsShadow) {
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.35, -0.4}, {0.35, 0.4})),
                                    Block({0.1, 0.1, 0.15}, {0.05, 0.1, kTop_m + 0.075})})
                                .cloud);
  ASSERT_EQ(supports.At(kTop_m).size(), 1u);
  EXPECT_TRUE(supports.At(kTop_m)[0].shape.holes.empty());
  EXPECT_LT(supports.Outside_m({0.05, 0.1}), -0.2);
  EXPECT_LT(supports.Outside_m({0.15, 0.12}), -0.15);
}

TEST(SupportPolygon, FindsAShelfAndATableAtOnce) {
  const double table_m = 0.5, shelf_m = 0.95;
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.3, -0.5}, {0.1, 0.5}), table_m),
                                    Slab(Rectangle({0.1, -0.5}, {0.4, 0.5}), shelf_m)})
                                .cloud);
  EXPECT_EQ(supports.At(table_m).size(), 1u);
  EXPECT_EQ(supports.At(shelf_m).size(), 1u);
  EXPECT_LT(supports.Outside_m({-0.1, 0.1}, table_m), 0);
  EXPECT_LT(supports.Outside_m({0.25, 0.1}, shelf_m), 0);
  EXPECT_GT(supports.Outside_m({-0.1, 0.1}, shelf_m), 0.1);
}

// As low as the top of a carton on the floor, but the floor is seen under it.
TEST(SupportPolygon, OfALowTableUnderWhichTheFloorIsSeen) {
  const double top_m = 0.38;
  const SupportsOf supports(ScanOf({Slab(Rectangle({0.2, -0.4}, {0.8, 0.4}), top_m)}).cloud);
  EXPECT_EQ(supports.At(top_m).size(), 1u);
  EXPECT_LT(supports.Outside_m({0.5, 0}, top_m), -0.15);
  EXPECT_FALSE(supports.At(0).empty());
}

TEST(SupportPolygon, OfAShelfCloseAboveACounter) {
  const double shelf_m = kTop_m + 0.3;
  const SupportsOf supports(ScanOf({Slab(Rectangle({-0.35, -0.5}, {0.45, 0.5})),
                                    Slab(Rectangle({0.2, -0.35}, {0.45, 0.35}), shelf_m)})
                                .cloud);
  EXPECT_EQ(supports.At(shelf_m).size(), 1u);
  EXPECT_EQ(supports.At(kTop_m).size(), 1u);
}

TEST(SupportPolygon, IsNoneOfACartonOnTheFloor) {
  const double top_m = 0.38;
  const SupportsOf carton(ScanOf({Block({0.6, 0.8, top_m}, {0.5, 0, top_m / 2})}).cloud);
  EXPECT_TRUE(carton.At(top_m).empty());
  // Two cartons of one height between which the floor is seen are not a table either.
  const SupportsOf two(ScanOf({Block({0.6, 0.3, top_m}, {0.5, -0.2, top_m / 2}),
                               Block({0.6, 0.3, top_m}, {0.5, 0.2, top_m / 2})})
                           .cloud);
  EXPECT_TRUE(two.At(top_m).empty());
}

PointCloud Shuffled(const PointCloud& cloud) {
  PointCloud shuffled;
  shuffled.points = cloud.points;
  std::shuffle(shuffled.points.begin(), shuffled.points.end(), std::mt19937(1));
  shuffled.width = static_cast<int>(shuffled.points.size());
  return shuffled;
}

TEST(SupportPolygon, OfACloudFromAnywhereClosesNarrowerGaps) {
  const SupportsOf supports(
      Shuffled(ScanOf({Slab(Rectangle({-0.35, -0.4}, {0.25, 0.4})), Pole()}).cloud));
  EXPECT_EQ(supports.At(kTop_m).size(), 1u);
  EXPECT_LT(supports.Outside_m({-0.2, 0}), 0);
}

}  // namespace
}  // namespace cwm::perception
