// Convex pairs in difficult poses, with certificates. The worst errors are the table in
// collision/kernels/README.md, asserted here.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "collision/kernels/exact.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

PairDistance Solve(const PosedPair& pair) {
  const auto a = PrepareExact(pair.a), b = PrepareExact(pair.b);
  return ExactDistance({*a, pair.X_FA}, {*b, pair.X_FB});
}

// Moves B so that the pair touches, up to an offset as from rounding or from a grip.
void Kiss(RandomPairs& random, PosedPair& pair) {
  constexpr std::array<double, 13> kOffsets_m = {0,    1e-15, -1e-15, 1e-12, -1e-12, 1e-9, -1e-9,
                                                 1e-7, -1e-7, 1e-5,   -1e-5, 1e-3,   -1e-3};
  const PairDistance answer = Solve(pair);
  const double offset_m = kOffsets_m[static_cast<std::size_t>(random.Index(13))];
  pair.X_FB.translation() -= (answer.distance_m - offset_m) * answer.normal;
}

// Allowed worst errors, as shares of the size of the pair.
struct Limits {
  double distance_share;  // separated: by the certificate; overlapping: along the normal
  double depth_share;     // against the least overlap that a search finds
  double witness_share;   // distance of the witness points
};

// derived: exact_closed_forms_test.cc bounds closed forms to 1e-12. Here the certificate itself
// rounds in poses 10 m away (1e-15 m each, a few of them) for shapes of a millimetre, and a face's
// normal is given at edges nearer than 1e-11.
constexpr Limits kClosedForm = {1e-11, 1e-11, 1e-8};
// derived: the axes of capsules may cross at 1e-9 rad and 1e-12 m; their direction is not more
// accurate.
constexpr Limits kCapsules = {1e-9, 1e-9, 1e-8};
// derived: GJK and an expanding polytope with a gap of 1e-9 for polyhedra; needles and sheets
// magnify it.
constexpr Limits kPolyhedra = {2e-9, 2e-9, 5e-8};
// derived: a gap of 1e-9 of the size lets the witness of a round shape move by sqrt(2e-9) of it,
// 4.5e-5, for a curvature of the size. measured: 1.6e-5 was the worst of 300,000 pairs. If the
// search runs out of work for shapes of millimetres, its bound still keeps kPromise_m below and the
// answer is called exact, though not as a share of the size.
constexpr Limits kRound = {2e-8, 5e-7, 4.5e-5};
// The accuracy of kExact for any size, see pair_distance.h.
constexpr double kPromise_m = 1e-7;

Limits LimitsFor(ShapeKind a, ShapeKind b) {
  const auto either = [&](ShapeKind kind) { return a == kind || b == kind; };
  if (either(ShapeKind::kPlate) && either(ShapeKind::kSphere)) return kPolyhedra;
  if (either(ShapeKind::kHalfSpace) || either(ShapeKind::kSphere)) return kClosedForm;
  if (either(ShapeKind::kCylinder) || either(ShapeKind::kCone)) return kRound;
  const auto is_capsule_or_box = [](ShapeKind kind) {
    return kind == ShapeKind::kCapsule || kind == ShapeKind::kBox;
  };
  if (a != b && is_capsule_or_box(a) && is_capsule_or_box(b)) return kClosedForm;
  if (a == ShapeKind::kCapsule && b == ShapeKind::kCapsule) return kCapsules;
  return kPolyhedra;
}

using KindPair = std::tuple<ShapeKind, ShapeKind>;
class ExactConvexPair : public ::testing::TestWithParam<KindPair> {};

constexpr int kPairs = 150;  // chosen: the sanitizers finish within ten seconds
constexpr int kSearchedPairs = 15;

bool AreEndless(ShapeKind a, ShapeKind b) {
  return a == ShapeKind::kHalfSpace && b == ShapeKind::kHalfSpace;
}

TEST_P(ExactConvexPair, IsProvenInAnyPoseAndWhenKissing) {
  const auto [kind_a, kind_b] = GetParam();
  if (AreEndless(kind_a, kind_b)) GTEST_SKIP() << "a layer, or no depth";
  const Limits limits = LimitsFor(kind_a, kind_b);
  RandomPairs random(17);
  double worst_distance = 0, worst_witness = 0, worst_depth = 0;
  for (int k = 0; k < kPairs; ++k) {
    PosedPair pair = random.Pair(kind_a, kind_b);
    if (k % 2 == 1) Kiss(random, pair);
    const PairDistance answer = Solve(pair);
    const bool has_half_space = kind_a == ShapeKind::kHalfSpace || kind_b == ShapeKind::kHalfSpace;
    const double size = has_half_space ? 10 : SizeOf(pair);
    ASSERT_NEAR(answer.normal.norm(), 1, 1e-12) << k;
    ASSERT_TRUE(answer.point_a.allFinite() && answer.point_b.allFinite()) << k;
    ASSERT_TRUE(answer.accuracy == Accuracy::kExact || answer.accuracy == Accuracy::kBounded) << k;
    const Vector3 gap = answer.point_b - answer.point_a - answer.distance_m * answer.normal;
    ASSERT_LE(gap.norm(), 1e-11 * size) << k;
    if (has_half_space) continue;  // the overlap along any other normal is infinite
    const AnswerErrors errors = ErrorsOf(pair, answer);
    ASSERT_LE(errors.distance_m, std::max(kPromise_m, limits.distance_share * size)) << k;
    worst_distance = std::max(worst_distance, errors.distance_m / size);
    worst_witness = std::max(worst_witness, errors.witness_m / size);
    if (answer.distance_m >= 0 || k % (kPairs / kSearchedPairs) > 1) continue;
    const double least = SearchMinOverlap(pair, 200, 3);
    const double excess_m = -answer.distance_m - least - answer.bound_m;
    ASSERT_LE(excess_m, kPromise_m) << k;
    worst_depth = std::max(worst_depth, excess_m / size);
  }
  EXPECT_LE(worst_distance, limits.distance_share);
  EXPECT_LE(worst_depth, limits.depth_share);
  EXPECT_LE(worst_witness, limits.witness_share);
}

TEST_P(ExactConvexPair, OfHandSizedShapesIsRightToATenthOfAMicrometre) {
  const auto [kind_a, kind_b] = GetParam();
  const bool has_half_space = kind_a == ShapeKind::kHalfSpace || kind_b == ShapeKind::kHalfSpace;
  if (has_half_space) GTEST_SKIP() << "a formula, and no certificate";
  RandomPairs random(31);
  for (int k = 0; k < kPairs; ++k) {
    PosedPair pair = random.HandSizedPair(kind_a, kind_b);
    const PairDistance first = Solve(pair);
    pair.X_FB.translation() += (random.Uniform(-0.02, 1) - first.distance_m) * first.normal;
    const PairDistance answer = Solve(pair);
    EXPECT_LE(answer.bound_m, kPromise_m) << k;
    EXPECT_LE(ErrorsOf(pair, answer).distance_m, kPromise_m) << k;
    if (answer.distance_m >= 0 || k % 4 != 0) continue;
    EXPECT_LE(-answer.distance_m - SearchMinOverlap(pair, 200, 3), kPromise_m) << k;
  }
}

TEST_P(ExactConvexPair, SwapsWithItsArgumentsAndMovesWithTheFrame) {
  const auto [kind_a, kind_b] = GetParam();
  if (AreEndless(kind_a, kind_b)) GTEST_SKIP() << "a layer, or no depth";
  RandomPairs random(29);
  for (int k = 0; k < 60; ++k) {
    const PosedPair pair = random.Pair(kind_a, kind_b);
    const PairDistance answer = Solve(pair);
    const PairDistance swapped = Solve({pair.b, pair.a, pair.X_FB, pair.X_FA});
    const Pose X_GF = random.AnyPose(3);
    const PairDistance moved = Solve({pair.a, pair.b, X_GF * pair.X_FA, X_GF * pair.X_FB});
    // Twice the gap of the search for shapes up to 50 m together, plus the bounds of the answers.
    const double tolerance_m = 1e-7 + answer.bound_m + swapped.bound_m + moved.bound_m;
    ASSERT_NEAR(swapped.distance_m, answer.distance_m, tolerance_m) << k;
    ASSERT_NEAR(moved.distance_m, answer.distance_m, tolerance_m) << k;
    if (!(answer.distance_m > 1e-3)) continue;  // an overlap may have several normals
    ASSERT_GT(swapped.normal.dot(-answer.normal), 1 - 1e-6) << k;
  }
}

constexpr std::array<ShapeKind, 8> kKinds = {
    ShapeKind::kSphere,  ShapeKind::kBox,    ShapeKind::kCylinder, ShapeKind::kCone,
    ShapeKind::kCapsule, ShapeKind::kConvex, ShapeKind::kPlate,    ShapeKind::kHalfSpace};

INSTANTIATE_TEST_SUITE_P(AllPairs, ExactConvexPair,
                         ::testing::Combine(::testing::ValuesIn(kKinds),
                                            ::testing::ValuesIn(kKinds)),
                         [](const ::testing::TestParamInfo<KindPair>& info) {
                           return std::string(NameOf(std::get<0>(info.param))) + "_" +
                                  std::string(NameOf(std::get<1>(info.param)));
                         });

}  // namespace
}  // namespace cwm::collision
