// Round solids shrink where rays were seen to pass.
#include "perception/primitive_fit/shrink_to_free_space.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "perception/modeler/object_modeler.h"
#include "perception/solids/free_space.h"
#include "tests/perception/model/surfaces.h"

namespace cwm::perception {
namespace {

const Vector3 kEye(-0.8, 0, 0.8);
constexpr double kRadius_m = 0.1, kLength_m = 0.12;

// An upright tin at the origin; of the points only the viewpoint matters.
struct Tin {
  Tin() : octree(points), connectivity(points) {
    points.viewpoint = kEye;
    solid.shape = Cylinder{.radius_m = kRadius_m, .length_m = kLength_m};
    solid.X_MS.translation().z() = 0.5 * kLength_m;
    solid.parameter_sigma = {0.001, 0.001, 0.001, 0.01, 0.01, 0, 0.001};
  }

  // The ray from the sensor through this place in the plane of the lid, and beyond.
  static FreeRay Over(double x, double y) {
    const Vector3 at(x, y, kLength_m);
    const Vector3 way = (at - kEye).normalized();
    FreeRay ray{.p = {}, .sigma_m = 0.0015};
    for (int k = 0; k < kSamplesPerRay; ++k) {
      ray.p[static_cast<std::size_t>(k)] = at + (0.05 * k - 0.1) * way;
    }
    return ray;
  }

  // Adds `beside` rays that pass beside the tin and `over` rays over its lid, evenly from `from_x`
  // to its far rim.
  void See(int beside, int over, double from_x) {
    for (int k = 0; k < beside; ++k) free.rays.push_back(Over(0.05, 0.15 + 0.001 * k));
    for (int k = 0; k < over; ++k) {
      free.rays.push_back(Over(from_x + (kRadius_m - from_x) * k / over, 0));
    }
  }

  Solid Shrunk() const {
    std::vector<Solid> solids = {solid};
    ShrinkToFreeSpace({points, octree, connectivity, noise, options, work, {}, free}, solids);
    return solids.front();
  }

  ModelPoints points;
  Octree octree;
  Connectivity connectivity;
  SensorNoise noise;
  ModelerOptions options;
  Work work;
  FreeRays free;
  Solid solid;
};

double RadiusOf(const Solid& solid) { return std::get<Cylinder>(solid.shape).radius_m; }

TEST(ShrinkToFreeSpace, EndsBeforeTheRaysAndStaysWhereItFacesTheSensor) {
  Tin tin;
  tin.See(200, 20, 0.092);
  ASSERT_GT(CrossingRayShare(tin.solid, tin.free), 0.05);
  const Solid shrunk = tin.Shrunk();
  EXPECT_LT(CrossingRayShare(shrunk, tin.free), CrossingRayShare(tin.solid, tin.free) / 3 + 1e-9);
  EXPECT_NEAR(shrunk.X_MS.translation().x() - RadiusOf(shrunk), -kRadius_m, 1e-12);
  EXPECT_NEAR(shrunk.X_MS.translation().z(), 0.5 * kLength_m, 1e-12);
  const double moved_m = kRadius_m - RadiusOf(shrunk);
  EXPECT_GT(moved_m, 0.002);
  EXPECT_LT(moved_m, 0.005);
  EXPECT_NEAR(shrunk.parameter_sigma[6], std::hypot(0.001, moved_m), 1e-9);
  EXPECT_NEAR(shrunk.parameter_sigma[1], 0.001, 1e-9);  // across, where it did not move
}

TEST(ShrinkToFreeSpace, TakesFewRaysForNoise) {
  Tin tin;
  tin.See(400, 7, 0.092);
  EXPECT_EQ(RadiusOf(tin.Shrunk()), kRadius_m);
}

TEST(ShrinkToFreeSpace, LeavesToOthersWhatNoWidthOfTheImageExplains) {
  Tin tin;
  tin.See(200, 20, -0.05);
  EXPECT_EQ(RadiusOf(tin.Shrunk()), kRadius_m);
}

TEST(ShrinkToFreeSpace, HasNoSideThatFacesASensorAboveIt) {
  Tin tin;
  tin.See(200, 20, 0.092);
  tin.points.viewpoint = Vector3(0, 0, 1);
  EXPECT_EQ(RadiusOf(tin.Shrunk()), kRadius_m);
}

// A tin on a table whose lid seems to end before its far rim, as in images of real Kinects: the
// image shows the table behind it instead.
struct ShortLid {
  static constexpr double kTrue_m = 0.09, kHigh_m = 0.08;

  ShortLid(double short_m, std::uint64_t seed) {
    constexpr double kElevation_rad = 40 * std::numbers::pi / 180;
    const ScannedObject whole =
        ScanOnTable(OfOnePart(Cylinder{.radius_m = kTrue_m, .length_m = kHigh_m}, 0.5 * kHigh_m),
                    0.75, kElevation_rad, seed);
    scan.passing = whole.passing;
    scan.points.viewpoint = whole.points.viewpoint;
    const Eigen::Vector3f eye = whole.points.viewpoint.cast<float>();
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < whole.points.size(); ++i) {
      const Eigen::Vector3f& p = whole.points.points[i];
      const bool is_short =
          p.z() > 0.9 * kHigh_m && p.x() > 0 && p.head<2>().norm() > kTrue_m - short_m;
      if (!is_short) kept.push_back(i);
      if (!is_short || i % 7 != 0) continue;
      scan.passing.ends.push_back(eye + eye.z() / (eye.z() - p.z()) * (p - eye));
      scan.passing.sigma_m.push_back(whole.points.sigma_m[i]);
    }
    scan.passing.around_count = scan.passing.ends.size();
    scan.points = Subset(whole.points, kept);
  }

  ScannedObject scan;
};

TEST(ShrinkToFreeSpace, TinsEndWhereTheirLidsAreShort) {
  constexpr double kNoise_m = 0.002;
  for (const double short_m : {0.0, 0.012}) {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const ScannedObject scan = ShortLid(short_m, seed).scan;
      const ObjectModel model = ModelObject(scan.points, scan.X_WSupport, {}, {}, {}, scan.passing);
      ASSERT_EQ(model.shapes.size(), 1u);
      const auto* tin = std::get_if<Cylinder>(&model.shapes.front().shape);
      ASSERT_NE(tin, nullptr);
      const double x_m = model.shapes.front().X_OS.translation().x();
      EXPECT_NEAR(x_m - tin->radius_m, -ShortLid::kTrue_m, kNoise_m);
      // A third of the rays that cross it may stay.
      EXPECT_GT(x_m + tin->radius_m, ShortLid::kTrue_m - short_m - 0.003);
      EXPECT_LT(x_m + tin->radius_m, ShortLid::kTrue_m - short_m / 3 + kNoise_m);
    }
  }
}

}  // namespace
}  // namespace cwm::perception
