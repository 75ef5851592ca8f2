#include "perception/solids/round_solid.h"

#include <gtest/gtest.h>

#include "tests/perception/solids/seen_fits.h"

namespace cwm::perception {
namespace {

constexpr double kByItsRim_m = 3e-4;  // how far the rim of its cap may move a sure wall
const Vector3 kAslant(-0.6, 0, 0.6);

// A can of 3 cm radius whose wall is seen from 2 to 9 cm above the ground.
struct WallOfACan {
  WallOfACan() { fits = {seen.Fit(model, seen.AddWall(model.AsCone(), -0.03, 0.04))}; }
  std::optional<Solid> Made() {
    used.assign(fits.size(), 0);
    return MakeRoundSolid(fits[0], fits, seen.Context(kFloorAtZero), kFloorAtZero, used);
  }

  SeenFits seen{kAslant};
  CylinderModel model{.point = Vector3(0, 0, 0.05), .radius_m = 0.03};
  std::vector<ShapeFit> fits;
  std::vector<char> used;
};

// The cylinder of the solid; throws if there is none, which fails the test.
Cylinder CylinderOf(const std::optional<Solid>& solid) {
  return std::get<Cylinder>(solid.value().shape);
}

TEST(MakeRoundSolid, EndsWithItsWallOnTheGroundJustBelow) {
  WallOfACan can;
  const auto solid = can.Made();
  const double length_m = CylinderOf(solid).length_m;
  EXPECT_NEAR(CylinderOf(solid).radius_m, 0.03, kSeenExact_m);
  EXPECT_NEAR(length_m, 0.09, kSeenEnd_m);
  EXPECT_NEAR(solid->X_MS.translation().z(), 0.5 * length_m, kSeenExact_m);
  EXPECT_EQ(solid->parameter_sigma.size(), 7u);
  can.model.side = SeenFrom::kInside;
  can.fits[0].model = can.model;
  EXPECT_FALSE(can.Made());
  can.fits[0].model = PlaneModel();
  EXPECT_FALSE(can.Made());
}

TEST(MakeRoundSolid, TakesForItsCapADiscThatIsNeitherTooWideNorTooHigh) {
  WallOfACan can;
  can.fits.push_back(can.seen.AddDisc({0, 0, 0.1}, 0.06));
  can.fits.push_back(can.seen.AddDisc({0, 0, 0.15}, 0.03));
  const auto open = can.Made();
  EXPECT_NEAR(CylinderOf(open).length_m, 0.09, kSeenEnd_m);
  EXPECT_EQ(can.used, (std::vector<char>{0, 0, 0}));
  WallOfACan capped;
  capped.fits.push_back(capped.seen.AddDisc({0, 0, 0.1}, 0.03));
  const auto solid = capped.Made();
  EXPECT_NEAR(CylinderOf(solid).length_m, 0.1, kByItsRim_m);
  EXPECT_NEAR(CylinderOf(solid).radius_m, 0.03, kByItsRim_m);
  EXPECT_EQ(capped.used, (std::vector<char>{0, 1}));
  EXPECT_EQ(solid->inliers.size(), capped.seen.size());
}

TEST(MakeRoundSolid, GivesACupTheRadiiOfItsEndsAndLiftsABallThatNoiseSinks) {
  SeenFits seen(kAslant);
  const ConeModel cup{.point = Vector3(0, 0, 0.05), .radius_m = 0.04, .slope = 0.2};
  const std::vector<ShapeFit> fits = {seen.Fit(cup, seen.AddWall(cup, -0.04, 0.05))};
  std::vector<char> used(1, 0);
  const auto solid = MakeRoundSolid(fits[0], fits, seen.Context(kFloorAtZero), kFloorAtZero, used);
  const Cone cone = std::get<Cone>(solid.value().shape);
  EXPECT_NEAR(cone.radius_bottom_m, 0.03, kSeenExact_m) << "on the ground";
  EXPECT_NEAR(cone.radius_top_m, 0.05, 0.2 * kSeenEnd_m);
  EXPECT_NEAR(cone.length_m, 0.1, kSeenEnd_m);
  const std::vector<std::uint32_t> top = {seen.AddPoint({0, 0, 0.08}, Vector3::UnitZ())};
  const auto made = [&](double height_m, SeenFrom side) {
    const SphereModel ball{.center = Vector3(0, 0, height_m), .radius_m = 0.04, .side = side};
    return MakeRoundSolid(seen.Fit(ball, top), {}, seen.Context(kFloorAtZero), kFloorAtZero, used);
  };
  const Solid lifted = made(0.035, SeenFrom::kOutside).value();
  EXPECT_NEAR(lifted.X_MS.translation().z(), 0.04, kSeenExact_m);
  EXPECT_NEAR(lifted.parameter_sigma.back(), SeenFits::kFitSigma, 1e-8) << "of the radius";
  EXPECT_FALSE(made(0.02, SeenFrom::kOutside));
  EXPECT_FALSE(made(0.04, SeenFrom::kInside));
}

TEST(MakeDisc, IsTheCircleThatAPlateEndsInAndNothingOfASquare) {
  SeenFits seen(kAslant);
  seen.AddDisc({0, 0, 0}, 0.04, 4000);
  Solid plate;
  plate.X_MS.translation() = Vector3(0.01, -0.005, 0);  // on its face, not its middle
  plate.shape = Plate{.outline = {}, .holes = {}, .thickness_m = 0.006};
  plate.parameter_sigma = {0.001, 0.002, 0, 0.003};
  const auto disc = MakeDisc(plate, seen.Context());
  EXPECT_NEAR(CylinderOf(disc).radius_m, 0.04, 0.001);
  EXPECT_EQ(CylinderOf(disc).length_m, 0.006);
  EXPECT_LT((disc->X_MS.translation() - Vector3(0, 0, -0.003)).norm(), 0.001);
  ASSERT_EQ(disc->parameter_sigma.size(), 7u);
  EXPECT_EQ(disc->parameter_sigma[4], 0.002) << "its axis is the face's normal";
  seen.options.search_cylinders = false;
  EXPECT_FALSE(MakeDisc(plate, seen.Context()));
  SeenFits of_square(kAslant);
  of_square.AddFace({-0.035, -0.035, 0}, {0.07, 0, 0}, {0, 0.07, 0});
  EXPECT_FALSE(MakeDisc(plate, of_square.Context()));
  plate.shape = Box{{0.08, 0.08, 0.006}};
  seen.options.search_cylinders = true;
  EXPECT_FALSE(MakeDisc(plate, seen.Context()));
}

}  // namespace
}  // namespace cwm::perception
