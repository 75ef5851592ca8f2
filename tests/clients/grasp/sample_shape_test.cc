#include "clients/grasp/sample_shape.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace cwm::grasp {
namespace {

using Eigen::Vector3d;

constexpr double kExact_m = 1e-12;

// Expects that both pads touch: the surface is at both ends of the closing line, and no nearer.
void ExpectPadsOnSurface(const Candidates& candidates,
                         const std::function<double(const Vector3d&)>& distance_m) {
  ASSERT_FALSE(candidates.list.empty());
  for (const Candidate& candidate : candidates.list) {
    const Eigen::Matrix3d R = candidate.X_FG.linear();
    EXPECT_NEAR((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 0, 1e-12);
    EXPECT_NEAR(R.determinant(), 1, 1e-12);
    for (const double side : {-0.5, 0.5}) {
      const Vector3d pad =
          candidate.X_FG * Vector3d(side * candidate.width_m, 0, candidate.retraction_m);
      EXPECT_NEAR(distance_m(pad), 0, 1e-9) << candidate.strategy;
    }
  }
}

bool HasApproach(const Candidates& candidates, const Vector3d& approach) {
  return std::any_of(candidates.list.begin(), candidates.list.end(), [&](const Candidate& c) {
    return (c.X_FG.linear().col(2) - approach).norm() < 1e-9;
  });
}

TEST(SampleBox, PadsTouchOppositeFacesFromAllSides) {
  const Candidates found = SampleBox(Box{0.05, 0.2, 0.3}, {});
  const Vector3d half(0.025, 0.1, 0.15);
  ExpectPadsOnSurface(found, [&](const Vector3d& p) { return (p.cwiseAbs() - half).maxCoeff(); });
  for (const Candidate& candidate : found.list) {
    EXPECT_NEAR(std::abs(candidate.X_FG.linear()(0, 0)), 1, kExact_m);  // the only axis that fits
    EXPECT_DOUBLE_EQ(candidate.width_m, 0.05);
  }
  for (const Vector3d& approach :
       {Vector3d(0, 1, 0), Vector3d(0, -1, 0), Vector3d(0, 0, 1), Vector3d(0, 0, -1),
        Vector3d(0, std::numbers::sqrt2 / 2, std::numbers::sqrt2 / 2)}) {
    EXPECT_TRUE(HasApproach(found, approach)) << approach.transpose();
  }
}

TEST(SampleBox, OpeningLessTwoGapsIsTheLimit) {
  const SamplerOptions options{.gripper = {.opening_m = 0.08}, .min_gap_m = 0.002};
  EXPECT_FALSE(SampleBox(Box{0.99 * 0.076, 1, 1}, options).list.empty());
  const Candidates none = SampleBox(Box{1.01 * 0.076, 1, 1}, options);
  EXPECT_TRUE(none.list.empty());
  EXPECT_DOUBLE_EQ(none.min_width_m, 1.01 * 0.076);
}

TEST(SampleCylinder, PadsTouchAcrossTheWallAndTheEnds) {
  const Candidates found = SampleCylinder(Cylinder{0.03, 0.07}, {});
  ExpectPadsOnSurface(found, [](const Vector3d& p) {
    return std::max(std::hypot(p.x(), p.y()) - 0.03, std::abs(p.z()) - 0.035);
  });
  EXPECT_TRUE(HasApproach(found, -Vector3d::UnitZ()));
  EXPECT_TRUE(std::any_of(found.list.begin(), found.list.end(),
                          [](const Candidate& c) { return c.strategy == "cylinder ends"; }));
}

TEST(SampleCone, WidthIsTheLocalOneAndTiltIsThatOfTheWall) {
  const Candidates found = SampleCone(Cone{0.02, 0.03, 0.1}, {});
  ExpectPadsOnSurface(
      found, [](const Vector3d& p) { return std::hypot(p.x(), p.y()) - (0.025 + 0.1 * p.z()); });
  EXPECT_NEAR(found.list.front().tilt_rad, std::atan(0.1), kExact_m);
}

TEST(SampleCone, FrictionLimitsTheTilt) {
  // The wall falls by 0.4 of its height, the limit for friction 0.4.
  const auto wall = [](double slope) { return Cone{0.005 + slope * 0.06, 0.005, 0.06}; };
  EXPECT_FALSE(SampleCone(wall(0.99 * 0.4), {.friction = 0.4}).list.empty());
  const Candidates slippery = SampleCone(wall(1.01 * 0.4), {.friction = 0.4});
  for (const Candidate& candidate : slippery.list) EXPECT_EQ(candidate.strategy, "cone ends");
  EXPECT_NEAR(slippery.min_tilt_rad, std::atan(1.01 * 0.4), kExact_m);
}

TEST(SampleSphere, EveryLineRunsThroughTheMiddle) {
  const Candidates found = SampleSphere(Sphere{0.035}, {});
  ExpectPadsOnSurface(found, [](const Vector3d& p) { return p.norm() - 0.035; });
  EXPECT_TRUE(HasApproach(found, -Vector3d::UnitZ()));
}

TEST(SampleVessel, OneFingerInsideAndOneOutsideOfTheRim) {
  Vessel vessel{.rim_radius_m = 0.06, .foot_radius_m = 0.06, .height_m = 0.1};
  vessel.outer_profile = Polygon{{0.06, 0.06}, {-0.05, 0.05}};
  vessel.inner_profile = Polygon{{0.056, 0.056, 0}, {0.05, -0.046, -0.046}};
  const Candidates found = SampleVessel(vessel, {});
  ASSERT_FALSE(found.list.empty());  // 120 mm wide as a whole, so only the rim fits
  for (const Candidate& candidate : found.list) {
    EXPECT_EQ(candidate.strategy, "rim");
    EXPECT_NEAR(candidate.width_m, 0.004, kExact_m);
    EXPECT_NEAR(candidate.X_FG.translation().head<2>().norm(), 0.058, kExact_m);
    EXPECT_NEAR(candidate.X_FG.linear()(2, 2), -1, kExact_m);
  }
}

TEST(SampleHandle, ClosesAcrossItsLength) {
  const Candidates found = SampleHandle(Box{0.012, 0.03, 0.08}, Vector3d::UnitZ(), {});
  ASSERT_FALSE(found.list.empty());
  for (const Candidate& candidate : found.list) {
    EXPECT_NEAR(candidate.X_FG.linear()(2, 0), 0, kExact_m);
  }
}

}  // namespace
}  // namespace cwm::grasp
