// An object that lies touches its support.
#include "perception/fit/ground_contact.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "perception/fit/solid.h"
#include "tests/perception/fit/fit_input.h"

namespace cwm::perception {
namespace {

constexpr double kRadius_m = 0.03, kLength_m = 0.12;
constexpr double kContact_m = 0.0015;  // accuracy of the update: 1 mm, and its linearisation error

// The upper half of a can that lies along x on z = 0, seen from above.
OrientedPoints LyingCan() {
  OrientedPoints points;
  points.viewpoint = Vector3(0, 0, 1);
  for (double x = -kLength_m / 2; x <= kLength_m / 2; x += 0.002) {
    for (double turn_rad = -1.2; turn_rad <= 1.2; turn_rad += 0.06) {
      const Vector3 n(0, std::sin(turn_rad), std::cos(turn_rad));
      points.points.push_back((Vector3(x, 0, kRadius_m) + kRadius_m * n).cast<float>());
      points.normals.push_back(n.cast<float>());
      points.sigma_m.push_back(0.0015f);
      points.normal_sigma_rad.push_back(0.05f);
      points.cloud_index.push_back(static_cast<std::uint32_t>(points.cloud_index.size()));
    }
  }
  return points;
}

struct Fixture : FitInput {
  Fixture() : FitInput(SubsampleForSearch(LyingCan(), 4000)) {
    for (std::uint32_t i = 0; i < points.size(); ++i) all.push_back(i);
  }
  FitContext Context() const {
    return FitInput::Context(Ground{.known = true, .point = Local(Vector3::Zero())});
  }
  ShapeFit Fit(const CylinderModel& model, double sigma) const {
    ShapeFit fit;
    fit.model = model;
    fit.inliers = all;
    fit.covariance = sigma * sigma * Eigen::MatrixXd::Identity(5, 5);
    return fit;
  }
  CylinderModel Can(double height_m, double tilt_rad, double radius_m) const {
    return {.point = Local(Vector3(0, 0, height_m)),
            .axis = Vector3(std::cos(tilt_rad), 0, std::sin(tilt_rad)),
            .radius_m = radius_m};
  }
  double LowestEnd_m(const ShapeFit& fit) const {
    const auto& can = std::get<CylinderModel>(fit.model);
    const double across = std::sqrt(1 - can.axis.z() * can.axis.z());
    double lowest_m = 1;
    for (const double end_m : {-kLength_m / 2, kLength_m / 2}) {
      const Vector3 center = can.point + end_m * can.axis + points.origin_L;
      lowest_m = std::min(lowest_m, center.z() - across * can.radius_m);
    }
    return lowest_m;
  }
  std::vector<char> Available() const { return std::vector<char>(points.size(), 1); }

  std::vector<std::uint32_t> all;
};

TEST(GroundContact, RaisesWhatSinksAndLowersWhatFloatsWithinItsUncertainty) {
  const Fixture f;
  // Tilted so that one end sinks by 3 mm and the other floats by as much.
  const ShapeFit tilted = f.Fit(f.Can(kRadius_m, 0.05, kRadius_m), 0.01);
  ASSERT_LT(f.LowestEnd_m(tilted), -0.002);
  const auto rested = RestOnGround(tilted, f.Context(), f.Available());
  ASSERT_TRUE(rested);
  EXPECT_NEAR(f.LowestEnd_m(*rested), 0, kContact_m);
  const auto& can = std::get<CylinderModel>(rested->model);
  EXPECT_LT(std::abs(can.axis.z()), kContact_m / (kLength_m / 2)) << "both ends touch";
  EXPECT_LT(rested->covariance.trace(), tilted.covariance.trace());
}

TEST(GroundContact, LeavesAloneWhatIsSurelyAboveTheGround) {
  const Fixture f;
  const ShapeFit above = f.Fit(f.Can(kRadius_m + 0.004, 0, kRadius_m), 1e-4);
  const auto rested = RestOnGround(above, f.Context(), f.Available());
  ASSERT_TRUE(rested);
  EXPECT_EQ(f.LowestEnd_m(*rested), f.LowestEnd_m(above));
}

TEST(GroundContact, RefusesWhatSurelySinks) {
  const Fixture f;
  const ShapeFit below = f.Fit(f.Can(kRadius_m - 0.02, 0, kRadius_m), 1e-5);
  EXPECT_FALSE(RestOnGround(below, f.Context(), f.Available()));
}

TEST(GroundContact, IsForSpheresAndForWhatDoesNotStand) {
  const Fixture f;
  ShapeFit fit = f.Fit(f.Can(kRadius_m, 0, kRadius_m), 0.001);
  EXPECT_TRUE(CanRestOnGround(fit, f.Context()));
  std::get<CylinderModel>(fit.model).axis = Vector3::UnitZ();
  EXPECT_FALSE(CanRestOnGround(fit, f.Context()));
  fit.model = SphereModel{.center = Vector3::Zero(), .radius_m = kRadius_m};
  EXPECT_TRUE(CanRestOnGround(fit, f.Context()));
  fit.model = PlaneModel{};
  EXPECT_FALSE(CanRestOnGround(fit, f.Context()));
}

}  // namespace
}  // namespace cwm::perception
