#include "perception/simulation/virtual_scanner.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "collision/geometry/aabb.h"
#include "collision/geometry/signed_distance.h"
#include "collision/geometry/tessellate.h"

namespace cwm::perception {
namespace {

constexpr double kWarpRms_m = 0.0013;                  // as in virtual_scanner.h
constexpr double kRandomDropOut = 0.015;               // of the pixels, beside steep faces
constexpr double kCorrelationArea_px = 4 * 4 * 2 * 2;  // integral of the correlation over the image

// A wall of one face at depth z, turned by `tilt_rad` about the camera's y axis.
SimulatedScene Wall(double depth_m, double tilt_rad) {
  SimulatedObject wall{.name = "wall", .parts = {{.shape = HalfSpace{}}}};
  wall.X_WO =
      MakePose({0, 0, depth_m},
               Quaternion(Eigen::AngleAxisd(std::numbers::pi + tilt_rad, Vector3::UnitY())));
  return {.objects = {wall}};
}

// A camera with a narrow lens, whose rays all meet the wall at nearly the same angle.
PinholeCamera NarrowCamera() {
  return {
      .width = 320, .height = 240, .focal_px = 5250, .center_x_px = 159.5, .center_y_px = 119.5};
}

bool IsReturn(const Eigen::Vector3f& p) { return p.allFinite(); }

// The error of a point on the wall along its own ray.
double RangeError_m(const Eigen::Vector3f& p_C, const SimulatedObject& wall) {
  const Vector3 p = p_C.cast<double>();
  const Vector3 normal = wall.X_WO.linear().col(2);
  const double ideal_share = normal.dot(wall.X_WO.translation()) / normal.dot(p);
  return p.norm() * (1 - ideal_share);
}

struct ErrorImage {
  int width = 0;
  int height = 0;
  std::vector<double> error_m;  // NaN for no return
};

ErrorImage ErrorsOn(const SimulatedScene& wall, const SimulatedCloud& scan) {
  ErrorImage image{.width = scan.cloud.width, .height = scan.cloud.height, .error_m = {}};
  for (const auto& p : scan.cloud.points) {
    image.error_m.push_back(IsReturn(p) ? RangeError_m(p, wall.objects[0]) : std::nan(""));
  }
  return image;
}

double MeanProduct(const ErrorImage& image, int du, int dv) {
  double sum = 0;
  int count = 0;
  for (int v = 0; v + dv < image.height; ++v) {
    for (int u = 0; u + du < image.width; ++u) {
      const double product =
          image.error_m[v * image.width + u] * image.error_m[(v + dv) * image.width + u + du];
      if (std::isnan(product)) continue;
      sum += product;
      ++count;
    }
  }
  return sum / count;
}

double Rms(const ErrorImage& image) { return std::sqrt(MeanProduct(image, 0, 0)); }

// The number of independent draws in the image. Squares of correlated values are less correlated
// than the values.
double IndependentDraws(const ErrorImage& image) {
  return image.width * image.height / kCorrelationArea_px;
}

TEST(VirtualScanner, PutsNoiselessPointsOnTheTrueSurfaces) {
  const SimulatedScene scene = KitchenCounter();
  const PinholeCamera camera = KitchenCamera();
  const SimulatedCloud scan = Scan(scene, camera, {.noiseless = true});
  ASSERT_EQ(scan.cloud.points.size(), 640U * 480U);
  for (std::size_t i = 0; i < scan.cloud.points.size(); ++i) {
    ASSERT_EQ(IsReturn(scan.cloud.points[i]), scan.object[i] >= 0);
    if (scan.object[i] < 0) continue;
    const SimulatedObject& object = scene.objects[scan.object[i]];
    const Placed<>& part = object.parts[scan.part[i]];
    const Vector3 p_S =
        (object.X_WO * part.X_FS).inverse() * camera.X_WC * scan.cloud.points[i].cast<double>();
    // Coordinates of up to 4 m as floats.
    ASSERT_NEAR(SignedDistance_m(part.shape, p_S), 0, 4 * 1.2e-7) << object.name;
  }
}

TEST(VirtualScanner, SeesEveryObjectOfTheKitchenCounter) {
  const SimulatedScene scene = KitchenCounter();
  const SimulatedCloud scan = Scan(scene, KitchenCamera(), {});
  std::map<int, int> points_of;
  for (const int object : scan.object) ++points_of[object];
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    EXPECT_GT(points_of[static_cast<int>(i)], 1000) << scene.objects[i].name;
  }
  const auto mug = std::find_if(scene.objects.begin(), scene.objects.end(),
                                [](const auto& object) { return object.name == "mug"; });
  ASSERT_NE(mug, scene.objects.end());
  int handle_points = 0;
  for (std::size_t i = 0; i < scan.object.size(); ++i) {
    if (scan.object[i] == mug - scene.objects.begin() && scan.part[i] > 0) ++handle_points;
  }
  EXPECT_GT(handle_points, 200);
}

TEST(VirtualScanner, DrawsAxialNoiseOfTheModelsSigma) {
  const SimulatedScene wall = Wall(1.2, 0);
  const SensorNoise noise{.model = SensorModel::kTimeOfFlight};
  const ErrorImage image = ErrorsOn(wall, Scan(wall, NarrowCamera(), {.noise = noise}));
  const double sigma_m = noise.AxialSigma_m(1.2);
  EXPECT_NEAR(Rms(image), sigma_m, 3 * sigma_m / std::sqrt(2 * IndependentDraws(image)));
}

TEST(VirtualScanner, AddsTheWarpOfTriangulatingCameras) {
  const SensorNoise noise{.model = SensorModel::kKinect};
  const SimulatedScene wall = Wall(1.2, 0);
  PinholeCamera camera;  // wide: the warp has room to vary
  const ErrorImage image = ErrorsOn(wall, Scan(wall, camera, {.noise = noise}));
  const double expected_m = std::hypot(noise.AxialSigma_m(1.2), kWarpRms_m);
  // The image holds few independent draws of the warp: about (640 / 131) * (480 / 131) waves.
  EXPECT_NEAR(Rms(image), expected_m, 3 * expected_m / std::sqrt(2 * 17));
}

TEST(VirtualScanner, CorrelatesNeighboursAsRealSensorsDo) {
  const SimulatedScene wall = Wall(1.2, 0);
  const SensorNoise noise{.model = SensorModel::kGiven, .given_sigma_m = 0.002};
  const ErrorImage image = ErrorsOn(wall, Scan(wall, NarrowCamera(), {.noise = noise}));
  const double variance = MeanProduct(image, 0, 0);
  const double tolerance = 3 / std::sqrt(IndependentDraws(image));
  for (const int step : {1, 2, 4, 8}) {
    EXPECT_NEAR(MeanProduct(image, step, 0) / variance, std::exp(-step / 4.0), tolerance) << step;
    EXPECT_NEAR(MeanProduct(image, 0, step) / variance, std::exp(-step / 2.0), tolerance) << step;
  }
}

TEST(VirtualScanner, MakesSlantedSurfacesNoisierByTheLateralNoise) {
  const double tilt_rad = 60 * std::numbers::pi / 180;
  const SimulatedScene wall = Wall(1.2, tilt_rad);
  const SensorNoise noise{.model = SensorModel::kTimeOfFlight};
  PinholeCamera camera = NarrowCamera();
  const ErrorImage image = ErrorsOn(wall, Scan(wall, camera, {.noise = noise}));
  // A displacement across the ray becomes a range error by the tangent of the slant.
  const double expected_m = std::hypot(noise.AxialSigma_m(1.2, tilt_rad),
                                       noise.LateralSigma_m(1.2, tilt_rad) * std::tan(tilt_rad));
  // The narrow lens sees depths of 1.2 m +- 5 %, and 3 sigma of the draws are added.
  EXPECT_NEAR(Rms(image), expected_m,
              expected_m * (0.05 + 3 / std::sqrt(2 * IndependentDraws(image))));
}

double ReturnedShare(double tilt_deg) {
  const SimulatedScene wall = Wall(1.2, tilt_deg * std::numbers::pi / 180);
  const SensorNoise noise{.model = SensorModel::kGiven, .given_sigma_m = 0.001};
  PinholeCamera camera = NarrowCamera();
  camera.focal_px *= 10;  // the angle of incidence is the same within 0.02 degrees
  const SimulatedCloud scan = Scan(wall, camera, {.noise = noise});
  const auto returned = std::count_if(scan.cloud.points.begin(), scan.cloud.points.end(), IsReturn);
  return static_cast<double>(returned) / static_cast<double>(scan.cloud.points.size());
}

TEST(VirtualScanner, DropsReturnsAtRandomAndAtGrazingAngles) {
  const double pixels = 320.0 * 240.0;
  const auto tolerance = [&](double share) { return 3 * std::sqrt(share * (1 - share) / pixels); };
  EXPECT_NEAR(ReturnedShare(0), 1 - kRandomDropOut, tolerance(kRandomDropOut));
  EXPECT_NEAR(ReturnedShare(69), 1 - kRandomDropOut, tolerance(kRandomDropOut));
  // Linear from 70 to 85 degrees; the angle varies by 0.2 degrees over the image.
  EXPECT_NEAR(ReturnedShare(77.5), 0.5, tolerance(0.5) + 0.2 / 15);
  EXPECT_EQ(ReturnedShare(86), 0);
}

TEST(VirtualScanner, MixesPixelsAtDepthEdgesOnlyAndFewOfThem) {
  const SimulatedCloud scan = Scan(KitchenCounter(), KitchenCamera(), {});
  int returned = 0;
  int mixed = 0;
  for (std::size_t i = 0; i < scan.cloud.points.size(); ++i) {
    if (!IsReturn(scan.cloud.points[i])) continue;
    ++returned;
    if (scan.object[i] < 0) ++mixed;
  }
  EXPECT_GT(mixed, 20);
  EXPECT_LT(mixed, returned / 200);  // half a percent
  const SimulatedScene wall = Wall(1.2, 0);
  const SimulatedCloud plain = Scan(wall, PinholeCamera(), {});
  ASSERT_EQ(plain.object.size(), 640U * 480U);
  for (std::size_t i = 0; i < plain.object.size(); ++i) {
    ASSERT_EQ(plain.object[i], IsReturn(plain.cloud.points[i]) ? 0 : -1);
  }
}

TEST(VirtualScanner, LeavesTheProjectorsShadowBesideAnObject) {
  SimulatedScene scene = Wall(1.2, 0);
  SimulatedObject ball{.name = "ball", .parts = {{.shape = Sphere{.radius_m = 0.1}}}};
  ball.X_WO = MakeTranslation(0, 0, 0.7);
  scene.objects.push_back(ball);
  const PinholeCamera camera;
  const SensorNoise kinect{.model = SensorModel::kKinect};
  const SimulatedCloud scan = Scan(scene, camera, {.noise = kinect});
  int lost_left = 0;
  int lost_right = 0;
  for (int u = 0; u < camera.width; ++u) {
    const bool lost = !IsReturn(scan.cloud.points[240 * camera.width + u]);
    (u < camera.width / 2 ? lost_left : lost_right) += lost;
  }
  // Disparities of 75 mm at the ball's rim (0.69 m) and on the wall: 57 and 33 pixels.
  EXPECT_GT(lost_right, 57 - 33 - 4);
  EXPECT_LT(lost_left, 20);
}

TEST(VirtualScanner, GivesTheSameBytesForTheSameSeedAndOthersForAnother) {
  const auto same = [](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
    return (!IsReturn(a) && !IsReturn(b)) || a == b;
  };
  const SimulatedScene scene = KitchenCounter();
  const auto points = [&](std::uint64_t seed) {
    return Scan(scene, KitchenCamera(), {.seed = seed}).cloud.points;
  };
  const auto first = points(1);
  const auto again = points(1);
  const auto other = points(2);
  ASSERT_EQ(first.size(), 640U * 480U);
  EXPECT_TRUE(std::equal(first.begin(), first.end(), again.begin(), same));
  EXPECT_FALSE(std::equal(first.begin(), first.end(), other.begin(), same));
}

TEST(RandomTable, HoldsObjectsThatDoNotTouchAndThatStandOnIt) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SimulatedScene scene = RandomTable(seed, 8);
    ASSERT_EQ(scene.objects.size(), 9U) << "seed " << seed;
    EXPECT_TRUE(scene.objects[0].is_support);
    const double top_m = scene.objects[0].X_WO.translation().z();
    for (std::size_t i = 1; i < scene.objects.size(); ++i) {
      const SimulatedObject& a = scene.objects[i];
      ASSERT_EQ(a.parts.size(), 1U);
      const Aabb bounds = TightBounds(a.parts[0].shape, a.X_WO * a.parts[0].X_FS);
      EXPECT_NEAR(bounds.min().z(), top_m, 1e-9) << a.name;
      for (const Vector3& vertex : Tessellate(a.parts[0].shape, 0.002).vertices) {
        const Vector3 p_W = a.X_WO * a.parts[0].X_FS * vertex;
        for (std::size_t j = 1; j < scene.objects.size(); ++j) {
          if (i == j) continue;
          const SimulatedObject& b = scene.objects[j];
          const Vector3 p_S = (b.X_WO * b.parts[0].X_FS).inverse() * p_W;
          ASSERT_GT(SignedDistance_m(b.parts[0].shape, p_S), 0.02) << a.name << " " << b.name;
        }
      }
    }
  }
}

TEST(RandomTable, DiffersFromSeedToSeed) {
  const SimulatedScene one = RandomTable(1, 5);
  const SimulatedScene two = RandomTable(2, 5);
  EXPECT_FALSE(one.objects[1].X_WO.isApprox(two.objects[1].X_WO));
  EXPECT_TRUE(one.objects[1].X_WO.isApprox(RandomTable(1, 5).objects[1].X_WO));
}

}  // namespace
}  // namespace cwm::perception
