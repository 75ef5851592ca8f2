#include "perception/describe_support.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

namespace cwm::perception {
namespace {

constexpr double kLength_m = 2, kWidth_m = 1;

// Random points on a face of 2 x 1 m, up to `seen_m` along it.
OrientedPoints Strewn(double points_per_m2, double seen_m) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> along(0, seen_m), across(0, kWidth_m);
  OrientedPoints points;
  for (int i = 0; i < points_per_m2 * seen_m * kWidth_m; ++i) {
    points.points.push_back(Vector3(along(random), across(random), 0).cast<float>());
  }
  return points;
}

// Lines of points, far apart from each other, as an image taken at a grazing angle has them.
OrientedPoints InLines(double in_line_m, double between_lines_m) {
  OrientedPoints points;
  for (double x = 0; x < kLength_m; x += between_lines_m) {
    for (double y = 0; y < kWidth_m; y += in_line_m) {
      points.points.push_back(Vector3(x, y, 0).cast<float>());
    }
  }
  return points;
}

double ObservedFraction(OrientedPoints points) {
  const std::size_t count = points.points.size();
  points.normals.assign(count, Eigen::Vector3f::UnitZ());
  points.sigma_m.assign(count, 0.002f);
  points.normal_sigma_rad.assign(count, 0.0f);
  points.cloud_index.resize(count);
  std::iota(points.cloud_index.begin(), points.cloud_index.end(), 0u);
  SegmentedSupport support;
  support.plate.shape =
      Plate{{{0, 0}, {kLength_m, 0}, {kLength_m, kWidth_m}, {0, kWidth_m}}, {}, 0.02};
  support.points = points.cloud_index;
  const DescribedSupport described =
      DescribeSupport(support, points, Pose::Identity(), WorldFloor::kUnknown, {}, {});
  return described.support.model->shapes[0].fit->observed_fraction;
}

// A support that is seen completely is observed completely, however far apart its points are.
TEST(DescribeSupport, ObservesAllOfAFaceInACloudOfAnyDensity) {
  for (const double points_per_m2 : {400000.0, 20000.0, 2000.0, 300.0}) {
    EXPECT_GT(ObservedFraction(Strewn(points_per_m2, kLength_m)), 0.98) << points_per_m2;
  }
  // The spacings at 4 m and 75 degrees of incidence, and at 2 m and 70 degrees.
  EXPECT_GT(ObservedFraction(InLines(0.0076, 0.029)), 0.98);
  EXPECT_GT(ObservedFraction(InLines(0.004, 0.011)), 0.98);
}

TEST(DescribeSupport, ObservesHalfOfAFaceOfWhichHalfIsSeen) {
  for (const double points_per_m2 : {400000.0, 20000.0, 2000.0}) {
    // The observed area may reach one cell farther all around; the widest cells hold four points
    // and more.
    const double cell_m = std::max(0.01, 4 / std::sqrt(points_per_m2));
    const double fraction = ObservedFraction(Strewn(points_per_m2, kLength_m / 2));
    EXPECT_GT(fraction, 0.49) << points_per_m2;
    EXPECT_LT(fraction, (kLength_m / 2 + cell_m) * (kWidth_m + cell_m) / (kLength_m * kWidth_m))
        << points_per_m2;
  }
}

}  // namespace
}  // namespace cwm::perception
