#include "perception/search/model_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "perception/cloud/tolerances.h"
#include "perception/search/plane_model.h"
#include "perception/search/sphere_model.h"
#include "tests/perception/search/exact_points.h"

namespace cwm::perception {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double kOfFloats = 1e-7;

// Four corners of a cube of 10 cm and the opposite corner, between a point that is not finite and
// one without a normal. The first corner claims no noise, the last claims the most.
OrientedPoints CornersOfACube() {
  ExactPoints exact;
  exact.Add(Vector3(std::numeric_limits<double>::quiet_NaN(), 0, 0), Vector3::UnitZ());
  for (const Vector3& p : {Vector3(0.1, 0.1, 0.1), Vector3(0, 0, 0.1), Vector3(0, 0.1, 0),
                           Vector3(0.1, 0, 0), Vector3(0, 0, 0)}) {
    exact.Add(p, Vector3::UnitZ());
  }
  exact.Add(Vector3(0.05, 0.05, 0.05), Vector3::Zero());
  exact.seen.sigma_m[1] = 0;
  exact.seen.sigma_m[5] = 0.0015f;
  exact.seen.viewpoint = Vector3(0, 0, 1);
  return exact.seen;
}

TEST(ModelPoints, AreTheUsableOnesInMortonOrderAboutTheirMean) {
  const ModelPoints points = SubsampleForSearch(CornersOfACube(), 100);
  // x is the least significant: the origin, along x, along y, along z, the opposite corner.
  EXPECT_THAT(points.index, ElementsAre(5, 4, 3, 2, 1));
  EXPECT_NEAR((points.origin_L - Vector3(0.04, 0.04, 0.04)).norm(), 0, kOfFloats);
  EXPECT_NEAR((points.p[1] - Vector3(0.06, -0.04, -0.04)).norm(), 0, kOfFloats);
  EXPECT_NEAR((points.viewpoint - Vector3(-0.04, -0.04, 0.96)).norm(), 0, kOfFloats);
  EXPECT_EQ(points.weight, 1);
  // The median of gaps of 1, sqrt(2), sqrt(2) and sqrt(2) edges.
  EXPECT_NEAR(points.spacing_m, 0.1 * std::numbers::sqrt2, kOfFloats);
  EXPECT_NEAR(points.gate_m[0], 0.0045, kOfFloats);
  EXPECT_NEAR(points.gate_m[1], 0.003, kOfFloats);
  EXPECT_GT(points.gate_m[4], 0);
  EXPECT_EQ(points.max_gate_m, points.gate_m[0]);
  const ModelPoints two = Subset(points, std::array<std::uint32_t, 2>{3, 0});
  EXPECT_THAT(two.index, ElementsAre(2, 5));
  EXPECT_EQ(two.p[1], points.p[0]);
  EXPECT_EQ(two.origin_L, points.origin_L);
}

TEST(ModelPoints, AreThinnedEvenlyAndEachStandsForAsMany) {
  ExactPoints exact;
  exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 32, 32);
  const ModelPoints points = SubsampleForSearch(exact.seen, 300);  // every fourth of 1024
  EXPECT_EQ(points.size(), 256u);
  EXPECT_EQ(points.weight, 4);
  std::array<int, 4> of_quadrant = {};
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3 p = points.p[i] + points.origin_L;
    of_quadrant[(p.x() > 0 ? 1u : 0u) + (p.y() > 0 ? 2u : 0u)] += 1;
    EXPECT_TRUE(i == 0 || points.key[i] > points.key[i - 1]) << i;
  }
  EXPECT_THAT(of_quadrant, ElementsAre(64, 64, 64, 64));
}

TEST(ModelPoints, OfNothingUsableAreNone) {
  EXPECT_EQ(SubsampleForSearch({}, 100).size(), 0u);
  ExactPoints exact;
  exact.Add(Vector3(0, 0, 0), Vector3::Zero());
  EXPECT_EQ(SubsampleForSearch(exact.seen, 100).size(), 0u);
  EXPECT_THAT(Subsampled({}, 4), IsEmpty());
  const std::array<std::uint32_t, 7> listed = {9, 8, 7, 6, 5, 4, 3};
  EXPECT_THAT(Subsampled(listed, 3), ElementsAre(9, 6, 3));
  EXPECT_THAT(Subsampled(listed, 7), ElementsAre(9, 8, 7, 6, 5, 4, 3));
}

TEST(ModelPoints, GateWhatIsOffOrTurnedAway) {
  EXPECT_NEAR(NormalGate_cos(0.01), std::cos(15 * kDegree), 1e-12);
  EXPECT_NEAR(NormalGate_cos(10 * kDegree), std::cos(30 * kDegree), 1e-12);
  EXPECT_NEAR(NormalGate_cos(1), std::cos(45 * kDegree), 1e-12);
  ExactPoints exact;
  const double sine = std::sin(14 * kDegree), cosine = std::cos(14 * kDegree);
  exact.Add(Vector3(0, 0, 0), Vector3(sine, 0, cosine));
  exact.Add(Vector3(1, 0, 0), Vector3(2 * sine * cosine, 0, 1 - 2 * sine * sine));  // 28 degrees
  const ModelPoints points = exact.Model();
  const auto plane_at = [&points](double z_m) {
    return PlaneModel{.point = Vector3(0, 0, z_m) - points.origin_L, .normal = Vector3::UnitZ()};
  };
  EXPECT_TRUE(IsInlier(plane_at(0.0029), points, 0));
  EXPECT_TRUE(IsInlier(plane_at(-0.0029), points, 0));
  EXPECT_FALSE(IsInlier(plane_at(0.0031), points, 0));
  EXPECT_FALSE(IsInlier(plane_at(-0.0031), points, 0));
  EXPECT_TRUE(IsInlier(plane_at(0.0031), points, 0, 2));
  EXPECT_FALSE(IsInlier(plane_at(0), points, 1));
  // The top of a ball, or of the hollow of one.
  SphereModel ball{.center = Vector3(0, 0, -0.05) - points.origin_L, .radius_m = 0.05};
  EXPECT_TRUE(IsInlier(ball, points, 0));
  ball.side = SeenFrom::kInside;
  EXPECT_FALSE(IsInlier(ball, points, 0));
}

}  // namespace
}  // namespace cwm::perception
