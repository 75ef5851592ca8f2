// Compares the depth of overlapping convex pairs with libccd's own EPA, called directly. Only a
// library that shares no code can be the referee, because the engines measure overlaps with the
// exact kernels.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "tests/contract/catalogue.h"
#include "tests/contract/libccd_referee.h"
#include "tests/contract/oracle.h"

namespace cwm::collision {
namespace {

constexpr int kPlacements = 100;

constexpr double kExact_m = 1e-7;  // the accuracy of kExact

// chosen: a bracket from libccd counts as narrow below this, a hundredth of the shapes. measured:
// for round shapes its polytope sometimes stops growing early, but nine in ten brackets are narrow.
constexpr double kNarrow_m = 1e-3;
constexpr double kNarrowShare = 0.9;

using Case = std::tuple<int, int>;  // indices into the catalogue
class DepthReferee : public ::testing::TestWithParam<Case> {};

TEST_P(DepthReferee, LibccdBracketsTheLeastTranslation) {
  const Shape& a = Catalogue()[std::get<0>(GetParam())].shape;
  const Shape& b = Catalogue()[std::get<1>(GetParam())].shape;
  if (!HasExtent(a) || !HasExtent(b)) GTEST_SKIP() << "not convex, or unbounded";
  const double reach_m = 0.7 * (Catalogue()[std::get<0>(GetParam())].size_m +
                                Catalogue()[std::get<1>(GetParam())].size_m);
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::mt19937 random(50);
  int overlapping = 0, answered = 0, narrow = 0;
  for (int i = 0; i < kPlacements; ++i) {
    const PlacedShape ours_a = Place(exact, a, RandomPose(random, 0.3));
    Pose X_WB = RandomPose(random, reach_m);
    X_WB.translation() += ours_a.X_WS.translation();
    const PlacedShape ours_b = Place(exact, b, X_WB);
    const PairDistance ours = exact.Distance(ours_a.get(), ours_b.get(), 1e3);
    if (ours.distance_m > -1e-4) continue;  // libccd's GJK is not reliable near touching
    ++overlapping;
    const std::optional<LibccdDepth> theirs = LibccdPenetration({a, ours_a.X_WS}, {b, ours_b.X_WS});
    if (!theirs.has_value()) continue;
    ++answered;
    // Translating by `parting_m` along libccd's direction separates the pair, so the least
    // translation is not larger. libccd's polytope lies inside the difference of the shapes, so the
    // minimum translation is not smaller than its depth.
    const double parting_m = std::min(-Gap_m(a, ours_a.X_WS, b, X_WB, theirs->normal_W),
                                      -Gap_m(a, ours_a.X_WS, b, X_WB, -theirs->normal_W));
    EXPECT_LE(-ours.distance_m, parting_m + kExact_m) << i;
    EXPECT_GE(-ours.distance_m + ours.bound_m, theirs->depth_m - kEpaTolerance_m) << i;
    if (parting_m - theirs->depth_m <= kNarrow_m) ++narrow;
  }
  ASSERT_GE(overlapping, 10);
  EXPECT_GE(answered, 0.9 * overlapping);
  EXPECT_GE(narrow, kNarrowShare * answered);
}

INSTANTIATE_TEST_SUITE_P(AllPairs, DepthReferee,
                         ::testing::Combine(::testing::Range(0, 12), ::testing::Range(0, 12)),
                         [](const ::testing::TestParamInfo<Case>& info) {
                           return Catalogue()[std::get<0>(info.param)].name +
                                  Catalogue()[std::get<1>(info.param)].name;
                         });

}  // namespace
}  // namespace cwm::collision
