#include "perception/cloud/sensor_noise.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

TEST(SlowErrors, AreTheWarpOfTriangulatingCamerasAndTheMultipathOfTimeOfFlight) {
  EXPECT_DOUBLE_EQ(SensorNoise{.model = SensorModel::kKinect}.WarpSigma_m(), kSlowWarp_m);
  EXPECT_DOUBLE_EQ(SensorNoise{.model = SensorModel::kRealSense}.WarpSigma_m(), kSlowWarp_m);
  EXPECT_DOUBLE_EQ(SensorNoise{.model = SensorModel::kTimeOfFlight}.WarpSigma_m(), kMultipath_m);
  for (const SensorModel model :
       {SensorModel::kTiltingLaser, SensorModel::kSickLms400, SensorModel::kGiven}) {
    EXPECT_EQ(SensorNoise{.model = model}.WarpSigma_m(), 0);
  }
}

TEST(SlowErrors, OfViewsInOneCloudHoldTheirRegistration) {
  const SensorNoise kinect{.model = SensorModel::kKinect, .registration_sigma_m = kRegistration_m};
  EXPECT_DOUBLE_EQ(kinect.WarpSigma_m(), std::hypot(kSlowWarp_m, kRegistration_m));
  const SensorNoise given{.model = SensorModel::kGiven, .registration_sigma_m = kRegistration_m};
  EXPECT_DOUBLE_EQ(given.WarpSigma_m(), kRegistration_m);
}

}  // namespace
}  // namespace cwm::perception
