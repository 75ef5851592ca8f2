// The gates of tracking follow from the sensor that took the scan.
#include "perception/track/scan_evidence.h"

#include <gtest/gtest.h>

#include <cmath>

namespace cwm::perception {
namespace {

const Vector3 kPlace_L(0, 0, -1.5);

ScanEvidence EvidenceOf(const SensorNoise& noise) {
  const PointCloud cloud{.points = {{0, 0, 1.5f}}, .normals = {}, .width = 1};
  return {cloud, Pose::Identity(), noise};
}

TEST(ScanEvidence, GatesOfSensorsWithoutSlowErrorsHoldNoWarp) {
  for (const SensorModel model :
       {SensorModel::kTiltingLaser, SensorModel::kSickLms400, SensorModel::kGiven}) {
    const SensorNoise noise{.model = model, .given_sigma_m = 0.0005};
    EXPECT_DOUBLE_EQ(EvidenceOf(noise).Gate_m(kPlace_L), 3 * noise.AxialSigma_m(1.5));
  }
}

TEST(ScanEvidence, GatesOfDepthCamerasHoldTheWarpOfBothScans) {
  for (const SensorModel model : {SensorModel::kKinect, SensorModel::kRealSense}) {
    const SensorNoise noise{.model = model};
    EXPECT_DOUBLE_EQ(EvidenceOf(noise).Gate_m(kPlace_L),
                     3 * std::hypot(noise.AxialSigma_m(1.5), std::sqrt(2) * kSlowWarp_m));
  }
}

TEST(ScanEvidence, GatesOfTimeOfFlightHoldTheMultipathOfBothScans) {
  const SensorNoise noise{.model = SensorModel::kTimeOfFlight};
  EXPECT_DOUBLE_EQ(EvidenceOf(noise).Gate_m(kPlace_L),
                   3 * std::hypot(noise.AxialSigma_m(1.5), std::sqrt(2) * kMultipath_m));
}

TEST(ScanEvidence, ASmallestMoveIsTheLargerOfWarpAndWhatAFitLeavesOfTheNoise) {
  const auto smallest = [](const SensorNoise& noise) {
    return EvidenceOf(noise).SmallestMove_m(kPlace_L);
  };
  EXPECT_DOUBLE_EQ(smallest({.model = SensorModel::kKinect}), 3 * std::sqrt(2) * kSlowWarp_m);
  // The noise of a fit to kMinInformed independent samples.
  const SensorNoise fine{.model = SensorModel::kGiven, .given_sigma_m = 0.0003};
  EXPECT_NEAR(smallest(fine), 3 * std::sqrt(2) * 0.0003 / std::sqrt(kMinInformed), 1e-9);
  EXPECT_GT(smallest({.model = SensorModel::kTimeOfFlight}), 3 * std::sqrt(2) * kSlowWarp_m);
}

}  // namespace
}  // namespace cwm::perception
