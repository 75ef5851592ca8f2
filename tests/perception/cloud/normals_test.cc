#include "perception/cloud/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;

constexpr int kWidth = 160, kHeight = 120;
constexpr float kFocal_px = 525;
constexpr double kNoise_m = 0.0015;

Vector3f Ray(int u, int v) {
  return {(static_cast<float>(u) - kWidth / 2.0f) / kFocal_px,
          (static_cast<float>(v) - kHeight / 2.0f) / kFocal_px, 1};
}

// depth(ray) returns z along the ray, NaN for no return; the noise is white and along the ray.
template <class Depth>
MeasuredPoints Image(Depth&& depth, double noise_m, const SensorNoise& told) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, noise_m > 0 ? noise_m : 1);
  PointCloud cloud;
  cloud.width = kWidth;
  cloud.height = kHeight;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const float z = depth(Ray(u, v)) + static_cast<float>(noise_m > 0 ? noise(random) : 0);
      cloud.points.push_back(Ray(u, v) * z);
    }
  }
  return *CollectMeasured(cloud, told);
}
template <class Depth>
MeasuredPoints Image(const Depth& depth, double noise_m, double told_sigma_m = kNoise_m) {
  return Image(depth, noise_m,
               SensorNoise{.model = SensorModel::kGiven, .given_sigma_m = told_sigma_m});
}

double Angle_rad(const Vector3f& a, const Vector3f& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

// The depth of a plane through (0, 0, 0.8).
auto PlaneDepth(const Vector3f& normal) {
  return [normal](const Vector3f& ray) { return 0.8f * normal.z() / normal.dot(ray); };
}

TEST(ImageNormals, OfANoiselessPlaneAreExactAndFaceTheSensor) {
  const Vector3f normal = Vector3f(0, -0.7f, -0.7f).normalized();
  MeasuredPoints measured = Image(PlaneDepth(normal), 0);
  EstimateImageNormals(measured, {.max_threads = 2});
  ASSERT_EQ(measured.oriented.normals.size(), std::size_t{kWidth} * kHeight);
  for (const Vector3f& n : measured.oriented.normals) EXPECT_LT(Angle_rad(n, normal), 0.01);
}

TEST(ImageNormals, OfANoisyPlaneStayWithinTheirStatedSigma) {
  const Vector3f normal = Vector3f(0.3f, -0.7f, -0.7f).normalized();
  MeasuredPoints measured = Image(PlaneDepth(normal), kNoise_m);
  EstimateImageNormals(measured, {.max_threads = 2});
  double squares = 0, stated = 0;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    squares += std::pow(Angle_rad(measured.oriented.normals[i], normal), 2);
    stated += std::pow(measured.oriented.normal_sigma_rad[i], 2);
  }
  // White noise averages out better than the correlated noise that sigma is stated for; errors have
  // two axes.
  EXPECT_LT(squares, 2 * stated);
}

// The pixels are 1.5 mm apart: more than seven standard deviations.
TEST(ImageNormals, OfASensorWithLessNoiseThanAPixelIsWide) {
  constexpr double kFine_m = 1e-4;
  const Vector3f normal = Vector3f(0.3f, -0.7f, -0.7f).normalized();
  MeasuredPoints measured = Image(PlaneDepth(normal), kFine_m, kFine_m);
  EstimateImageNormals(measured, {.max_threads = 2});
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    EXPECT_LT(measured.oriented.normal_sigma_rad[i], 0.08);  // in the corners, of 9 pixels
    EXPECT_LT(Angle_rad(measured.oriented.normals[i], normal),
              5 * measured.oriented.normal_sigma_rad[i]);
  }
}

TEST(ImageNormals, OfASphereArePointsMinusCenter) {
  constexpr float kRadius_m = 0.08f;
  const Vector3f center(0, 0, 0.8f);
  MeasuredPoints measured = Image(
      [&](const Vector3f& ray) {
        const float a = ray.squaredNorm(), b = ray.dot(center);
        const float root = b * b - a * (center.squaredNorm() - kRadius_m * kRadius_m);
        return root > 0 ? (b - std::sqrt(root)) / a : std::nanf("");
      },
      0);
  EstimateImageNormals(measured, {.max_threads = 1});
  int checked = 0;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    const Vector3f truth = (measured.oriented.points[i] - center) / kRadius_m;
    if (-truth.dot(measured.oriented.points[i].normalized()) < 0.8f) continue;  // near the rim
    EXPECT_LT(Angle_rad(measured.oriented.normals[i], truth), 0.1);
    ++checked;
  }
  EXPECT_GT(checked, 1000);
}

TEST(ImageNormals, DoNotReachAcrossADepthJump) {
  // Two planes face the sensor, 5 cm apart: a normal estimated from both would lean.
  MeasuredPoints measured =
      Image([](const Vector3f& ray) { return ray.x() < 0 ? 0.8f : 0.85f; }, 0);
  EstimateImageNormals(measured, {.max_threads = 2});
  ASSERT_EQ(measured.oriented.normals.size(), std::size_t{kWidth} * kHeight);
  for (const Vector3f& n : measured.oriented.normals) {
    EXPECT_LT(Angle_rad(n, -Vector3f::UnitZ()), 0.02);
  }
}

// 8 mm of noise, as a time-of-flight sensor has at 0.8 m, needs neighbours within 2 cm, not within
// the 5.6 cm that seven of a Kinect's standard deviations would be.
TEST(ImageNormals, OfACoarseSensorKeepAnEdgeApart) {
  constexpr double kCoarse_m = 0.008;
  constexpr float kSlope = 0.7f, kClear_m = 0.035f;
  MeasuredPoints measured = Image(
      [](const Vector3f& ray) { return 0.8f / (1 + kSlope * std::abs(ray.x())); }, 0, kCoarse_m);
  EstimateImageNormals(measured, {.max_threads = 2});
  int checked = 0;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    const float x = measured.oriented.points[i].x();
    if (std::abs(x) < kClear_m) continue;
    const Vector3f normal = -Vector3f(x > 0 ? kSlope : -kSlope, 0, 1).normalized();
    EXPECT_LT(Angle_rad(measured.oriented.normals[i], normal), 0.01);
    ++checked;
  }
  EXPECT_GT(checked, 1000);
}

// The errors of a laser's beams are independent: every point of a window adds information about its
// plane, and the stated sigma accounts for it.
TEST(ImageNormals, OfALaserScatterAsTheySay) {
  const SensorNoise laser{.model = SensorModel::kTiltingLaser};
  const Vector3f normal = Vector3f(0.3f, -0.4f, -0.8f).normalized();
  MeasuredPoints measured = Image(PlaneDepth(normal), laser.AxialSigma_m(0.8), laser);
  EstimateImageNormals(measured, {.max_threads = 2});
  double squares = 0, stated = 0;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    squares += std::pow(Angle_rad(measured.oriented.normals[i], normal), 2);
    stated += std::pow(measured.oriented.normal_sigma_rad[i], 2);
  }
  // Errors have two axes.
  EXPECT_LT(squares, 1.2 * 2 * stated);
  EXPECT_GT(squares, 0.5 * 2 * stated);
}

TEST(ImageNormals, KeepTheDirectionOfGivenOnesAndTurnThemToTheSensor) {
  PointCloud cloud;
  cloud.width = 20;
  cloud.height = 20;
  const Vector3f given = Vector3f(0.6f, 0, 0.8f);
  for (int i = 0; i < 400; ++i) {
    cloud.points.push_back(Ray(i % 20 + 70, i / 20 + 50) * 0.8f);
    cloud.normals.push_back(given);
  }
  MeasuredPoints measured = *CollectMeasured(cloud, {});
  EstimateImageNormals(measured, {.max_threads = 1});
  ASSERT_EQ(measured.oriented.size(), 400u);
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    const Vector3f& n = measured.oriented.normals[i];
    EXPECT_NEAR(std::abs(n.dot(given)), 1, 1e-5);
    EXPECT_LE(n.dot(measured.oriented.points[i]), 0);
  }
}

// The rule of window_normals.h, pixel by pixel and in double precision.
struct PlainNormal {
  Vector3 normal = Vector3::Zero();  // zero where nearly collinear points would amplify rounding
  double sigma_rad = 0;
};

PlainNormal NormalInWindow(const MeasuredPoints& measured, int row, int column) {
  const auto at = [&](int v, int u) {
    return measured.image[static_cast<std::size_t>(v) * static_cast<std::size_t>(measured.width) +
                          static_cast<std::size_t>(u)];
  };
  const auto i = static_cast<std::size_t>(at(row, column));
  const Vector3 p = measured.oriented.points[i].cast<double>();
  const float sigma_m = measured.oriented.sigma_m[i];
  const float pixel_m = measured.oriented.points[i].norm() * measured.pixel_angle_rad;
  const float sample_px = std::sqrt(measured.oriented.points_per_sample);
  const float of_noise_m = NormalRadius_m(sigma_m, sample_px * pixel_m);
  const float radius_m = std::max(of_noise_m, 2 * pixel_m);
  const float reach_m = std::max(
      std::min(kNormalRadius_sigma * sigma_m, std::hypot(of_noise_m, 3 * sigma_m)), 4 * pixel_m);
  const float px = std::clamp(radius_m / pixel_m, 2.0f, 64.0f);
  const int max_step = std::max(1, static_cast<int>(sample_px));
  const int step = std::clamp(static_cast<int>(std::lround(px / 3)), 1, max_step);
  const int reach = std::max(step, static_cast<int>(px) / step * step);
  Vector3 sum = Vector3::Zero();
  Matrix3 products = Matrix3::Zero();
  int count = 0;
  for (int v = row - reach; v <= row + reach; v += step) {
    for (int u = column - reach; u <= column + reach; u += step) {
      if (v < 0 || u < 0 || v >= measured.height || u >= measured.width || at(v, u) < 0) continue;
      const Vector3 q =
          measured.oriented.points[static_cast<std::size_t>(at(v, u))].cast<double>() - p;
      if (q.squaredNorm() > 2 * reach_m * reach_m) continue;
      sum += q;
      products += q * q.transpose();
      ++count;
    }
  }
  PlainNormal out;
  out.sigma_rad = NormalSigma_rad(
      sigma_m, radius_m,
      static_cast<float>(count * step * step) / measured.oriented.points_per_sample);
  if (count < 3) return out;
  const Matrix3 covariance = products / count - sum * sum.transpose() / (count * count);
  // Ten rounding errors of 6e-8, times this condition number, are less than a milliradian.
  constexpr double kWorstCondition = 1000;
  const double smallest = covariance.selfadjointView<Eigen::Lower>().eigenvalues()(0);
  if (!(smallest > covariance.trace() / kWorstCondition)) return out;
  out.normal = -(covariance.inverse() * p).normalized();
  return out;
}

TEST(ImageNormals, AgreeWithPlainSumsOverEachWindow) {
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(0, 1);
  // Steps in depth change the windows from pixel to pixel; gaps and the image's borders cut them.
  MeasuredPoints measured = Image(
      [&](const Vector3f& ray) {
        if (uniform(random) < 0.1f) return std::nanf("");
        const float step = std::floor(20 * ray.x()) + std::floor(15 * ray.y());
        return 1.2f + 0.15f * step + 0.3f * ray.x();
      },
      kNoise_m);
  EstimateImageNormals(measured, {.max_threads = 2});
  std::size_t compared = 0, conditioned = 0, apart = 0, off = 0;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      const std::int32_t i =
          measured.image[static_cast<std::size_t>(row) * kWidth + static_cast<std::size_t>(column)];
      if (i < 0) continue;
      const PlainNormal plain = NormalInWindow(measured, row, column);
      const Vector3f& n = measured.oriented.normals[static_cast<std::size_t>(i)];
      const float sigma_rad = measured.oriented.normal_sigma_rad[static_cast<std::size_t>(i)];
      ++compared;
      // A neighbour right at the radius may count in single precision and not in double.
      off += std::abs(sigma_rad - plain.sigma_rad) > 1e-6;
      if (plain.normal.isZero()) continue;
      ++conditioned;
      apart += !(Angle_rad(n, plain.normal.cast<float>()) < 1e-3);
    }
  }
  ASSERT_GT(conditioned, 15'000u);
  EXPECT_LT(off, compared / 1000);
  EXPECT_LT(apart, compared / 1000);
}

TEST(ImageNormals, AreTheSameBytesOnAnyNumberOfThreads) {
  const auto depth = PlaneDepth(Vector3f(0, -0.5f, -0.8f).normalized());
  MeasuredPoints one = Image(depth, kNoise_m), two = Image(depth, kNoise_m);
  EstimateImageNormals(one, {.max_threads = 1});
  EstimateImageNormals(two, {.max_threads = 2});
  EXPECT_EQ(one.oriented.normals, two.oriented.normals);
  EXPECT_EQ(one.oriented.normal_sigma_rad, two.oriented.normal_sigma_rad);
}

TEST(GridNormals, OfANoisyPlaneAgreeWithIt) {
  const Vector3f normal = Vector3f(0.2f, -0.6f, -0.7f).normalized();
  MeasuredPoints measured = Image(PlaneDepth(normal), kNoise_m);
  const VoxelGrid grid = VoxelGrid::Build(measured.oriented.points, 0.004f);
  EstimateGridNormals(measured.oriented, grid, 0.0104f, {.max_threads = 2});
  double squares = 0, stated = 0;
  for (std::size_t i = 0; i < measured.oriented.size(); ++i) {
    squares += std::pow(Angle_rad(measured.oriented.normals[i], normal), 2);
    stated += std::pow(measured.oriented.normal_sigma_rad[i], 2);
  }
  EXPECT_LT(squares, 2 * stated);
}

TEST(GridNormals, AreUnknownOnALine) {
  OrientedPoints points;
  for (int i = 0; i < 200; ++i) points.points.push_back({0.001f * static_cast<float>(i), 0, 1});
  points.normals.assign(200, Vector3f::Zero());
  points.sigma_m.assign(200, 0.002f);
  points.normal_sigma_rad.assign(200, 0);
  const VoxelGrid grid = VoxelGrid::Build(points.points, 0.004f);
  EstimateGridNormals(points, grid, 0.01f, {.max_threads = 1});
  for (const Vector3f& n : points.normals) EXPECT_TRUE(n.isZero());
}

}  // namespace
}  // namespace cwm::perception
