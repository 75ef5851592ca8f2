// The errors of each kind of sensor beside its plain noise.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>

#include "collision/geometry/signed_distance.h"
#include "perception/simulation/look_at.h"
#include "perception/simulation/multipath.h"
#include "perception/simulation/random_scenes.h"
#include "perception/simulation/sensor_errors.h"
#include "perception/simulation/several_views.h"
#include "perception/simulation/unorganised.h"

namespace cwm::perception {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// A half space beyond the plane through a point; the normal points towards the camera.
SimulatedObject Wall(const char* name, const Vector3& through_C, const Vector3& normal_C) {
  Pose X_CS = Pose::Identity();
  X_CS.linear() = BasisFromZ(normal_C.normalized());
  X_CS.translation() = through_C;
  return {.name = name, .parts = {{.shape = HalfSpace{}}}, .X_WO = X_CS};
}

SimulatedScene FlatWall(double depth_m) {
  return {.objects = {Wall("wall", {0, 0, depth_m}, -Vector3::UnitZ())}};
}

// Two walls that meet at a right angle in a vertical edge 1 m in front of the camera, which looks
// into the corner.
SimulatedScene Corner() {
  return {.objects = {Wall("left", {0, 0, 1}, {1, 0, -1}), Wall("right", {0, 0, 1}, {-1, 0, -1})}};
}

// A box that turns an edge towards the camera: convex.
SimulatedScene Edge() {
  SimulatedObject box{.name = "box", .parts = {{.shape = Box{.size_m = {0.5, 0.5, 2}}}}};
  box.X_WO =
      MakePose({0, 0, 1.35}, Quaternion(Eigen::AngleAxisd(45 * kDegree, Vector3::UnitY())) *
                                 Quaternion(Eigen::AngleAxisd(90 * kDegree, Vector3::UnitX())));
  return {.objects = {box}};
}

TEST(Multipath, LeavesFlatWallsAndConvexEdgesAlone) {
  const PinholeCamera camera;
  for (const SimulatedScene& scene : {FlatWall(1.2), Edge()}) {
    const RangeImage image = Render(scene, camera);
    const std::vector<float> bias_m = MultipathBias(image, camera);
    ASSERT_EQ(bias_m.size(), image.pixels.size());
    // Normals are floats: the faces see each other only by rounding.
    EXPECT_LT(*std::max_element(bias_m.begin(), bias_m.end()), 1e-5F);
    EXPECT_GE(*std::min_element(bias_m.begin(), bias_m.end()), 0);
  }
}

TEST(Multipath, RoundsAConcaveCorner) {
  const PinholeCamera camera;
  const std::vector<float> bias_m = MultipathBias(Render(Corner(), camera), camera);
  const auto at = [&](int u) { return bias_m[static_cast<std::size_t>(240) * camera.width + u]; };
  const float edge_m = at(320);
  const float beside_m = at(320 + 48);   // 80 mm to the side: on the wall
  EXPECT_GT(beside_m, edge_m + 0.002F);  // the walls move back more than the edge does
  EXPECT_LT(beside_m, 0.1F);
  EXPECT_LT(at(636), beside_m);  // and less again far from the corner
  // Symmetric, apart from the grid of patches.
  EXPECT_NEAR(at(320 - 48), beside_m, 0.3 * beside_m);
}

// |q| + |q - p| - |p| is at most 2 |q|, and half of it counts; the shares of light sum to less than
// one.
TEST(Multipath, AddsNoMoreThanTheFarthestRange) {
  const PinholeCamera camera;
  const std::vector<float> bias_m = MultipathBias(Render(Corner(), camera), camera);
  const double farthest_m = 1.0 * RayDirection(camera, 0, 0).norm();  // the edge is 1 m deep
  EXPECT_LT(*std::max_element(bias_m.begin(), bias_m.end()), 0.5 * farthest_m);
}

TEST(TimeOfFlight, MeasuresCornersTooFar) {
  const PinholeCamera camera;
  const SimulatedScene corner = Corner();
  const SimulatedCloud ideal = Scan(corner, camera, {.noiseless = true});
  const SimulatedCloud scan =
      Scan(corner, camera, {.noise = {.model = SensorModel::kTimeOfFlight}});
  double sum_m = 0;
  int count = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 320 + 32; u < 320 + 64; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      if (!scan.cloud.points[i].allFinite() || scan.object[i] < 0) continue;
      sum_m += scan.cloud.points[i].norm() - ideal.cloud.points[i].norm();
      ++count;
    }
  }
  const std::vector<float> bias_m = MultipathBias(Render(corner, camera), camera);
  const double expected_m = bias_m[static_cast<std::size_t>(240) * camera.width + 320 + 48];
  // Noise of 1 % at 1 m over 480 x 32 pixels, 16 of which carry one independent draw.
  const double sigma_m = 0.01 / std::sqrt(480 * 32 / 16.0);
  EXPECT_NEAR(sum_m / count, expected_m, 4 * sigma_m + 0.2 * expected_m);
}

// All points of one of a laser's scan lines on a floor are shifted together.
TEST(TiltingLaser, JittersByWholeLines) {
  const PinholeCamera camera{.focal_px = 525};
  const SimulatedScene ramp = {.objects = {Wall("ramp", {0, 0, 2}, {0, -1, -1})}};
  const SensorNoise laser{.model = SensorModel::kTiltingLaser};
  const SimulatedCloud ideal = Scan(ramp, camera, {.noiseless = true});
  const SimulatedCloud scan = Scan(ramp, camera, {.noise = laser, .seed = 5});
  double variance_of_lines = 0;
  double variance_within = 0;
  int lines = 0;
  double beams_per_line = 0;
  for (int v = 0; v < camera.height; ++v) {
    double sum = 0;
    double sum_squares = 0;
    int n = 0;
    for (int u = 0; u < camera.width; ++u) {
      const std::size_t i = static_cast<std::size_t>(v) * camera.width + u;
      if (!scan.cloud.points[i].allFinite() || scan.object[i] < 0) continue;
      // The range error, in units of the range change by one radian of tilt.
      const Vector3 p = ideal.cloud.points[i].cast<double>();
      const double error_m = scan.cloud.points[i].norm() - p.norm();
      sum += error_m;
      sum_squares += error_m * error_m;
      ++n;
    }
    if (n < 100) continue;
    ++lines;
    beams_per_line += n;
    variance_of_lines += (sum / n) * (sum / n);
    variance_within += (sum_squares - sum * sum / n) / (n - 1);
  }
  ASSERT_GT(lines, 300);
  variance_of_lines /= lines;
  variance_within /= lines;
  beams_per_line /= lines;
  // Within a line the beams err independently, by the axial sigma. If that were all, a line's mean
  // would vary by that sigma over the root of its beam count; it varies by far more.
  EXPECT_NEAR(std::sqrt(variance_within), laser.AxialSigma_m(2), 0.1 * laser.AxialSigma_m(2));
  EXPECT_GT(variance_of_lines, 3 * variance_within / beams_per_line);
  // At 45 degrees of incidence and about 2 m, 0.05 to 0.1 degrees are 1.7 to 3.5 mm of range. The
  // ramp is nearer at the top of the image and farther at its bottom: within a factor of two.
  EXPECT_GT(std::sqrt(variance_of_lines), 0.5 * 2 * std::tan(0.05 * kDegree));
  EXPECT_LT(std::sqrt(variance_of_lines), 2 * 3 * std::tan(0.10 * kDegree));
}

TEST(TiltingLaser, HasNoNoiseThatNeighboursShare) {
  const PinholeCamera camera;
  const SensorNoise laser{.model = SensorModel::kTiltingLaser};
  const SimulatedScene wall = FlatWall(2);
  const SensorErrors errors = DrawErrors(laser, Render(wall, camera), camera, 3);
  double product = 0;
  for (int v = 0; v < camera.height; ++v) {
    for (int u = 0; u + 1 < camera.width; ++u) {
      product += errors.axial.at(u, v) * errors.axial.at(u + 1, v);
    }
  }
  const double pairs = static_cast<double>(camera.height) * (camera.width - 1);
  EXPECT_NEAR(product / pairs, 0, 4 / std::sqrt(pairs));
}

TEST(SickLms400, IsMoreOrLessNoisyFromObjectToObjectAndBiasedAsAWhole) {
  SimulatedScene walls;
  for (int i = 0; i < 8; ++i) {  // side by side, all face on
    SimulatedObject board{.name = std::to_string(i),
                          .parts = {{.shape = Box{.size_m = {0.1, 1, 0.1}}}}};
    board.X_WO = MakeTranslation(-0.35 + 0.1 * i, 0, 1.05);
    walls.objects.push_back(board);
  }
  const PinholeCamera camera;
  const SensorNoise sick{.model = SensorModel::kSickLms400};
  const RangeImage image = Render(walls, camera);
  double min_bias_m = 1;
  double max_bias_m = -1;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SensorErrors errors = DrawErrors(sick, image, camera, seed);
    std::map<int, std::pair<double, int>> squares_of;
    for (std::size_t i = 0; i < image.pixels.size(); ++i) {
      ASSERT_EQ(errors.bias_m[i], errors.bias_m[0]);
      auto& [sum, count] = squares_of[image.pixels[i].object];
      sum += errors.axial.values[i] * errors.axial.values[i];
      ++count;
    }
    for (const auto& [object, sum] : squares_of) {
      if (object < 0) continue;
      const double sigma_m = sick.AxialSigma_m(1) * std::sqrt(sum.first / sum.second);
      const double tolerance = 1 + 4 / std::sqrt(2.0 * sum.second);
      EXPECT_GT(sigma_m * tolerance, kSickBrightSigma_m);
      EXPECT_LT(sigma_m / tolerance, kSickDarkSigma_m);
    }
    min_bias_m = std::min(min_bias_m, static_cast<double>(errors.bias_m[0]));
    max_bias_m = std::max(max_bias_m, static_cast<double>(errors.bias_m[0]));
  }
  EXPECT_GE(min_bias_m, -kSickBias_m);
  EXPECT_LE(max_bias_m, kSickBias_m);
  EXPECT_GT(max_bias_m - min_bias_m, kSickBias_m);
}

TEST(ShinyObjects, ReturnNothingAndHideWhatIsBehind) {
  SimulatedScene scene = FlatWall(1.2);
  SimulatedObject ball{.name = "ball", .parts = {{.shape = Sphere{.radius_m = 0.1}}}};
  ball.X_WO = MakeTranslation(0, 0, 0.8);
  ball.finish = Finish::kShiny;
  scene.objects.push_back(ball);
  for (const bool noiseless : {true, false}) {
    const SimulatedCloud scan = Scan(scene, PinholeCamera(), {.noiseless = noiseless});
    EXPECT_EQ(std::count(scan.object.begin(), scan.object.end(), 1), 0);
    // The middle of the ball, 20 pixels around: the wall behind it does not appear there either.
    for (int v = 220; v < 260; ++v) {
      for (int u = 300; u < 340; ++u) {
        ASSERT_FALSE(scan.cloud.points[static_cast<std::size_t>(v) * 640 + u].allFinite());
      }
    }
    EXPECT_GT(std::count(scan.object.begin(), scan.object.end(), 0), 200'000);
  }
}

TEST(Shuffling, KeepsEveryReturnWithItsTruth) {
  const SimulatedScene scene = KitchenCounter();
  const SimulatedCloud scan = Scan(scene, KitchenCamera(), {});
  const SimulatedCloud shuffled = Shuffled(scan, 7);
  EXPECT_FALSE(shuffled.cloud.organised());
  using Point = std::tuple<float, float, float, int, int>;
  const auto sorted = [](const SimulatedCloud& cloud) {
    std::vector<Point> points;
    for (std::size_t i = 0; i < cloud.cloud.points.size(); ++i) {
      const auto& p = cloud.cloud.points[i];
      if (p.allFinite()) {
        points.emplace_back(p.x(), p.y(), p.z(), cloud.object[i], cloud.part[i]);
      }
    }
    std::sort(points.begin(), points.end());
    return points;
  };
  EXPECT_EQ(sorted(scan), sorted(shuffled));
  EXPECT_EQ(static_cast<std::size_t>(shuffled.cloud.width), shuffled.cloud.points.size());
  // Neighbours in the list are unrelated: their mean distance is that of random pairs, decimetres.
  double sum_m = 0;
  for (std::size_t i = 1; i < shuffled.cloud.points.size(); ++i) {
    sum_m += (shuffled.cloud.points[i] - shuffled.cloud.points[i - 1]).norm();
  }
  EXPECT_GT(sum_m / static_cast<double>(shuffled.cloud.points.size()), 0.2);
  EXPECT_EQ(Shuffled(scan, 7).object, shuffled.object);
  EXPECT_NE(Shuffled(scan, 8).object, shuffled.object);
}

TEST(UpVector, IsOffByTheAngleAskedFor) {
  const Pose X_WC = LookAt({1, 2, 1.5}, Vector3(0.2, 0.1, 0.8));
  const Vector3 up_C = X_WC.linear().transpose() * Vector3::UnitZ();
  for (const double error_deg : {0.0, 0.5, 3.0, 90.0, 180.0}) {
    const Vector3 given_C = PerturbedUp(error_deg * kDegree, X_WC, 4);
    EXPECT_NEAR(given_C.norm(), 1, 1e-12);
    EXPECT_NEAR(std::atan2(given_C.cross(up_C).norm(), given_C.dot(up_C)), error_deg * kDegree,
                1e-7);
  }
}

// Noiseless views differ from the truth by the registration alone.
TEST(SeveralViews, AreRegisteredWithSmallErrorsButTheFirst) {
  const SimulatedScene scene = KitchenCounter();
  const PinholeCamera camera = KitchenCamera();
  const RegisteredViews views = ScanFromSeveralViews(scene, camera, 4, {.noiseless = true});
  ASSERT_EQ(views.X_WC.size(), 4U);
  EXPECT_FALSE(views.cloud.cloud.organised());
  EXPECT_TRUE(views.X_WC[0].isApprox(camera.X_WC));
  EXPECT_TRUE(views.X_CC[0].isApprox(Pose::Identity()));
  for (std::size_t i = 1; i < 4; ++i) {
    const Pose believed_W = camera.X_WC * views.X_CC[i];
    const Pose error = believed_W * views.X_WC[i].inverse();  // moves world points
    const double angle_rad = Eigen::AngleAxisd(error.linear()).angle();
    EXPECT_GE(angle_rad, 0.2 * kDegree);
    EXPECT_LE(angle_rad, 0.5 * kDegree);
    // The camera's target is a point of its axis; the shift there is the translation alone.
    double min_m = 1;
    for (double depth_m = 0.3; depth_m < 3; depth_m += 0.001) {
      const Vector3 p_W = views.X_WC[i] * Vector3(0, 0, depth_m);
      min_m = std::min(min_m, (error * p_W - p_W).norm());
    }
    EXPECT_LE(min_m, 0.005 + 1e-5);
    EXPECT_GT(RotationAngle_rad(views.X_WC[i].linear(), camera.X_WC.linear()), 5 * kDegree);
  }
}

TEST(SeveralViews, AreTakenFromFreeSpace) {
  constexpr double kRoom_m = 0.05;  // of free space for the camera itself
  for (const SceneFamily family :
       {SceneFamily::kTable, SceneFamily::kClutter, SceneFamily::kKitchen, SceneFamily::kVessels}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SimulatedView view = RandomScene(family, seed);
      view.camera.width = 8;  // only the positions of the cameras matter
      view.camera.height = 6;
      view.camera.focal_px = 6.5;
      view.camera.center_x_px = 3.5;
      view.camera.center_y_px = 2.5;
      const RegisteredViews views =
          ScanFromSeveralViews(view.scene, view.camera, 5, {.noiseless = true});
      for (const Pose& X_WC : views.X_WC) {
        for (const SimulatedObject& object : view.scene.objects) {
          for (const Placed<>& part : object.parts) {
            const Vector3 p_S = (object.X_WO * part.X_FS).inverse() * X_WC.translation();
            EXPECT_GT(SignedDistance_m(part.shape, p_S), kRoom_m) << seed << object.name;
          }
        }
      }
    }
  }
}

TEST(SeveralViews, ShowMoreOfAnObjectThanOne) {
  const SimulatedScene scene = KitchenCounter();
  const PinholeCamera camera = KitchenCamera();
  const auto sides_seen = [&](int count) {
    const RegisteredViews views = ScanFromSeveralViews(scene, camera, count, {.noiseless = true});
    // The directions, in steps of 5 degrees around the axis of the soup can, in which it has
    // points.
    const auto soup = std::find_if(scene.objects.begin(), scene.objects.end(),
                                   [](const auto& object) { return object.name == "soup"; });
    std::map<int, int> headings;
    for (std::size_t i = 0; i < views.cloud.object.size(); ++i) {
      if (views.cloud.object[i] != soup - scene.objects.begin()) continue;
      const Vector3 p_O =
          soup->X_WO.inverse() * camera.X_WC * views.cloud.cloud.points[i].cast<double>();
      if (p_O.z() > 0.1) continue;  // its lid at 0.11 m is seen from everywhere
      ++headings[static_cast<int>(std::atan2(p_O.y(), p_O.x()) / kDegree / 5)];
    }
    return headings.size();
  };
  EXPECT_GT(sides_seen(3), sides_seen(1) + 5);  // 40 degrees more on each side, in steps of 5
}

TEST(LookAt, LooksAtTheTargetLevelly) {
  const Vector3 eye(1, -2, 1.5);
  const Vector3 target(0.3, 0.2, 0.7);
  const Pose X_WC = LookAt(eye, target);
  const Vector3 seen = X_WC.inverse() * target;
  EXPECT_NEAR(seen.head<2>().norm(), 0, 1e-12);
  EXPECT_NEAR(seen.z(), (target - eye).norm(), 1e-12);
  EXPECT_NEAR(X_WC.linear()(2, 0), 0, 1e-12);  // x is level
  EXPECT_LT(X_WC.linear()(2, 1), 0);           // y is down
  EXPECT_NEAR(X_WC.linear().determinant(), 1, 1e-12);
  const Pose straight_down = LookAt({0, 0, 2}, Vector3::Zero());
  EXPECT_NEAR(straight_down.linear().determinant(), 1, 1e-12);
}

TEST(LookAt, TakesDistanceAndAngles) {
  const Vector3 target(0.1, 0.2, 0.8);
  const Pose X_WC =
      LookAt(target, ViewingDirection{.distance_m = 0.9, .down_rad = 0.5, .azimuth_rad = 1.2});
  EXPECT_NEAR((X_WC.translation() - target).norm(), 0.9, 1e-12);
  EXPECT_NEAR(X_WC.translation().z() - target.z(), 0.9 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(std::atan2(X_WC.linear()(1, 2), X_WC.linear()(0, 2)), 1.2, 1e-12);
}

}  // namespace
}  // namespace cwm::perception
