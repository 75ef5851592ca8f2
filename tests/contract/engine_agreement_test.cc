// Compares FCL and Bullet with the exact kernels where they computed the answer themselves:
// distances of separated pairs, and whether a pair overlaps. Answers in which the kernels replaced
// them are skipped, and their number is limited. Depths are tested in depth_referee_test.cc.
#include <gtest/gtest.h>

#include <cmath>

#include "collision/engines/convex_pieces.h"
#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

constexpr int kPlacements = 100;
constexpr double kFar_m = 1e3;
constexpr double kExact_m = 1e-7;  // the accuracy of kExact

// FCL's default tolerance of GJK, which applies to collision checks.
constexpr double kYesNo_m = 1e-6;

// The distance by which the circumscribed pieces of a truncated cone exceed it; 0 for other shapes,
// which have exact representations.
double PieceBound_m(const Shape& shape) {
  const auto* cone = std::get_if<Cone>(&shape);
  return cone != nullptr ? CircumscribedPieces(*cone).bound_m : 0;
}

struct Case {
  EngineKind referee;
  const CatalogueShape* a;
  const CatalogueShape* b;
};

std::vector<Case> AllCases() {
  std::vector<Case> cases;
  for (const EngineKind referee : {EngineKind::kFcl, EngineKind::kBullet}) {
    for (const CatalogueShape& a : Catalogue()) {
      for (const CatalogueShape& b : Catalogue()) {
        const ShapeKind kind_a = KindOf(a.shape);
        const ShapeKind kind_b = KindOf(b.shape);
        if (GetEngine(referee).Supports(kind_a, kind_b, QueryKind::kCollides) &&
            GetEngine(EngineKind::kExact).Supports(kind_a, kind_b, QueryKind::kCollides)) {
          cases.push_back({referee, &a, &b});
        }
      }
    }
  }
  return cases;
}

std::string NameOfCase(const ::testing::TestParamInfo<Case>& info) {
  return std::string(NameOf(info.param.referee)) + info.param.a->name + info.param.b->name;
}

// True for FCL's distances to meshes, except those to spheres and between meshes, which have closed
// forms.
bool IsBestEffort(EngineKind kind, const CatalogueShape& a, const CatalogueShape& b) {
  const auto has = [&](ShapeKind shape) {
    return KindOf(a.shape) == shape || KindOf(b.shape) == shape;
  };
  const bool both_meshes = KindOf(a.shape) == KindOf(b.shape);
  return kind == EngineKind::kFcl && has(ShapeKind::kMesh) && !has(ShapeKind::kSphere) &&
         !both_meshes;
}

class EngineAgreement : public ::testing::TestWithParam<Case> {
 protected:
  struct Both {
    PlacedShape a, b;
  };
  EngineAgreement()
      : referee_(GetEngine(GetParam().referee)), exact_(GetEngine(EngineKind::kExact)) {
    const Pose I = Pose::Identity();
    theirs_ = {Place(referee_, GetParam().a->shape, I), Place(referee_, GetParam().b->shape, I)};
    ours_ = {Place(exact_, GetParam().a->shape, I), Place(exact_, GetParam().b->shape, I)};
  }
  void Next() {
    ours_.a.X_WS = theirs_.a.X_WS = RandomPose(random_, 0.3);
    Pose X_WB = RandomPose(random_, GetParam().a->size_m + GetParam().b->size_m);
    X_WB.translation() += ours_.a.X_WS.translation();
    ours_.b.X_WS = theirs_.b.X_WS = X_WB;
  }

  std::mt19937 random_{30};
  const Engine& referee_;
  const Engine& exact_;
  Both theirs_, ours_;
};

TEST_P(EngineAgreement, OnCollision) {
  const double undecided_m =
      kYesNo_m + PieceBound_m(GetParam().a->shape) + PieceBound_m(GetParam().b->shape);
  int judged = 0;
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const double distance_m = exact_.Distance(ours_.a.get(), ours_.b.get(), kFar_m).distance_m;
    if (std::abs(distance_m) < undecided_m) continue;
    ++judged;
    EXPECT_EQ(referee_.Collides(theirs_.a.get(), theirs_.b.get()), distance_m < 0) << distance_m;
  }
  // chosen: 2e-4 m of the 0.3 m over which placements spread is one in a thousand.
  EXPECT_GE(judged, kPlacements - 2);
}

TEST_P(EngineAgreement, OnDistanceWithinWhatTheyClaim) {
  const auto [kind, a, b] = GetParam();
  if (!referee_.Supports(KindOf(a->shape), KindOf(b->shape), QueryKind::kDistance)) {
    GTEST_SKIP() << "yes and no only";
  }
  // FCL measures no distance to a half-space, so the kernels always answer.
  const bool kernels_answer =
      kind == EngineKind::kFcl &&
      (KindOf(a->shape) == ShapeKind::kHalfSpace || KindOf(b->shape) == ShapeKind::kHalfSpace);
  // Two planes that are not parallel always intersect.
  const bool always_meet =
      KindOf(a->shape) == ShapeKind::kHalfSpace && KindOf(b->shape) == ShapeKind::kHalfSpace;
  int separated = 0, judged = 0;
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance ours = exact_.Distance(ours_.a.get(), ours_.b.get(), kFar_m);
    if (always_meet) {
      const PairDistance theirs = referee_.Distance(theirs_.a.get(), theirs_.b.get(), kFar_m);
      EXPECT_LE(ours.distance_m, 0);
      EXPECT_EQ(theirs.distance_m, ours.distance_m);
      EXPECT_EQ(theirs.accuracy, ours.accuracy);
      continue;
    }
    ASSERT_NE(ours.accuracy, Accuracy::kDegraded);
    if (ours.distance_m <= 0) continue;
    ++separated;
    const PairDistance theirs = referee_.Distance(theirs_.a.get(), theirs_.b.get(), kFar_m);
    if (theirs.solver != (kernels_answer ? Solver::kKernels : Solver::kEngine)) continue;
    ++judged;
    const double tolerance_m = kExact_m + ours.bound_m + theirs.bound_m;
    // The witness points of a best-effort answer belong to the pieces, so it is never too near.
    EXPECT_GE(theirs.distance_m,
              ours.distance_m - tolerance_m - PieceBound_m(a->shape) - PieceBound_m(b->shape));
    if (theirs.accuracy == Accuracy::kDegraded) {
      EXPECT_TRUE(IsBestEffort(kind, *a, *b));
    } else {
      EXPECT_LE(theirs.distance_m, ours.distance_m + tolerance_m);
    }
  }
  if (always_meet) return;
  ASSERT_GE(separated, 15);
  EXPECT_GE(judged, 0.9 * separated);
}

INSTANTIATE_TEST_SUITE_P(AllPairs, EngineAgreement, ::testing::ValuesIn(AllCases()), NameOfCase);

}  // namespace
}  // namespace cwm::collision
