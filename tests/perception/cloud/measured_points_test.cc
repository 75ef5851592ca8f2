#include "perception/cloud/measured_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

using Eigen::Vector3f;
using ::testing::HasSubstr;

PointCloud Cloud(std::vector<Vector3f> points) {
  PointCloud cloud;
  cloud.width = static_cast<int>(points.size());
  cloud.points = std::move(points);
  return cloud;
}

void ExpectRefused(const PointCloud& cloud, const std::string& naming) {
  const auto measured = CollectMeasured(cloud, {});
  ASSERT_FALSE(measured.ok());
  EXPECT_EQ(measured.status().code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(measured.status().message()), HasSubstr(naming));
}

TEST(CollectMeasured, RefusesWhatIsNoCloudAndNamesWhy) {
  const float nan = std::nanf("");
  ExpectRefused(Cloud({}), "cloud.points is empty");
  ExpectRefused(Cloud({{nan, 0, 0}, {0, INFINITY, 1}}), "none of them finite");
  ExpectRefused(Cloud({{0, 0, 1}, {1e30f, 0, 0}}), "cloud.points[1]");
  PointCloud lying = Cloud({{0, 0, 1}, {0, 0, 2}, {0, 0, 3}});
  lying.width = 2;
  lying.height = 2;
  ExpectRefused(lying, "2 x 2");
  PointCloud normals = Cloud({{0, 0, 1}, {0, 0, 2}});
  normals.normals.resize(1);
  ExpectRefused(normals, "cloud.normals");
}

TEST(CollectMeasured, KeepsTheIndexOfEachFinitePoint) {
  const float nan = std::nanf("");
  const auto measured =
      CollectMeasured(Cloud({{nan, 0, 0}, {0, 0, 1}, {0, nan, 1}, {1, 0, 1}}), {});
  ASSERT_TRUE(measured.ok());
  EXPECT_THAT(measured->oriented.cloud_index, ::testing::ElementsAre(1, 3));
  EXPECT_FALSE(measured->organised());
}

// An image of a wall at 1 m with some pixels at 65 m, more than a Kinect sees.
TEST(CollectMeasured, LeavesOutTheFewPixelsBeyondTheSensorsRange) {
  PointCloud image;
  image.width = 40;
  image.height = 30;
  for (int v = 0; v < image.height; ++v) {
    for (int u = 0; u < image.width; ++u) {
      const float z = v == 0 && u < 2 ? 65 : 1;
      image.points.emplace_back(z * 0.002F * static_cast<float>(u - 20),
                                z * 0.002F * static_cast<float>(v - 15), z);
    }
  }
  const auto measured = CollectMeasured(image, {});
  ASSERT_TRUE(measured.ok());
  EXPECT_EQ(measured->beyond_range, 2u);
  EXPECT_EQ(measured->oriented.size(), 1198u);
  EXPECT_EQ(measured->oriented.cloud_index.front(), 2u);
  for (std::size_t i = 0; i < 600; ++i) image.points[i] *= 65;
  EXPECT_EQ(CollectMeasured(image, {})->beyond_range, 0u) << "they are not few";
  image.seen_from_origin = false;
  EXPECT_FALSE(CollectMeasured(image, {})->organised()) << "pixels are no rays";
}

TEST(SensorNoise, FollowsThePublishedKinectModel) {
  const SensorNoise noise;
  EXPECT_NEAR(noise.AxialSigma_m(0.8), 0.0012 + 0.0019 * 0.16, 1e-9);
  EXPECT_GT(noise.AxialSigma_m(0.8, 1.3), noise.AxialSigma_m(0.8, 1.0));
  EXPECT_TRUE(std::isfinite(noise.AxialSigma_m(0.8, 3.2)));
  EXPECT_NEAR(noise.LateralSigma_m(1.05), 0.8 * 1.05 / 525, 1e-9);
}

TEST(SensorNoise, ThatIsGivenIsNoLessThanFloatsResolve) {
  const auto sigma_m = [](double given_m) {
    return SensorNoise{.model = SensorModel::kGiven, .given_sigma_m = given_m}.AxialSigma_m(2);
  };
  EXPECT_EQ(sigma_m(1e-9), 1e-5);
  EXPECT_EQ(sigma_m(3e-4), 3e-4);
  const SensorNoise stereo{
      .model = SensorModel::kGiven, .given_sigma_m = 0.001, .given_quadratic_per_m = 0.002};
  EXPECT_DOUBLE_EQ(stereo.AxialSigma_m(3), 0.019);
}

// The expected distance of a flat support's points from its plane depends on the sensor: a Kinect
// warps, others do not.
TEST(SensorNoise, TellsWhatAFlatSupportLooksLike) {
  OrientedPoints points;
  points.sigma_m = {0.01f, 1e-5f};
  EXPECT_NEAR(points.UsualPlaneTolerance_m(0), 0.06f, 1e-6f);
  points.spread = SensorNoise{.model = SensorModel::kTimeOfFlight}.SpreadAboutPlanes();
  EXPECT_NEAR(points.UsualPlaneTolerance_m(0), 0.035f, 1e-6f);
  EXPECT_EQ(points.WidePlaneTolerance_m(1), kUnevenness_m)
      << "no table is as even as a scanner sees";
}

// The same disparity error is a larger angle in a narrower image.
TEST(SensorNoise, OfARealSenseFollowsTheWidthOfItsImage) {
  PointCloud cloud = Cloud(std::vector<Vector3f>(4, Vector3f(0, 0, 2)));
  const SensorNoise real_sense{.model = SensorModel::kRealSense};
  EXPECT_NEAR(NoiseIn(cloud, real_sense).AxialSigma_m(2), 4 * 0.1 / (320 * 0.05), 1e-9);
  cloud.width = 1280;
  cloud.height = 720;
  EXPECT_NEAR(NoiseIn(cloud, real_sense).AxialSigma_m(2), 4 * 0.1 / (640 * 0.05), 1e-9);
  EXPECT_NEAR(NoiseIn(cloud, real_sense).LateralSigma_m(2), 0.5 * 2 / 640, 1e-9);
  EXPECT_EQ(NoiseIn(cloud, {}).AxialSigma_m(2), SensorNoise().AxialSigma_m(2)) << "of a Kinect";
}

TEST(CollectMeasured, TakesTheNoiseOfTheImage) {
  PointCloud cloud;  // of 160 x 120 pixels over 90 degrees
  cloud.width = 160;
  cloud.height = 120;
  for (int i = 0; i < 160 * 120; ++i) {
    const int row = i / 160, column = i % 160;
    const Vector3f ray(static_cast<float>(column - 80) / 80, static_cast<float>(row - 60) / 80, 1);
    cloud.points.push_back(ray);
  }
  const auto measured = CollectMeasured(cloud, {.model = SensorModel::kRealSense});
  ASSERT_TRUE(measured.ok());
  EXPECT_NEAR(measured->oriented.sigma_m[0], 0.1 / (80 * 0.05), 1e-6);
}

}  // namespace
}  // namespace cwm::perception
