// Laws that every engine obeys on every pair of its capability table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "collision/geometry/signed_distance.h"
#include "tests/contract/catalogue.h"
#include "tests/contract/oracle.h"

namespace cwm::collision {
namespace {

constexpr int kPlacements = 60;
constexpr double kFar_m = 1e3;

// The tolerance of an answer: 1e-7 for kExact (pair_distance.h), plus its bound.
constexpr double kExact_m = 1e-7;
double Tolerance_m(const PairDistance& answer) { return kExact_m + answer.bound_m; }

// derived: iterative solvers whose distance is accurate to 1e-9 give witness points accurate to
// about its square root.
constexpr double kWitness_m = 2e-4;

// Smaller gaps count as an overlap for Bullet (bullet_engine.cc).
constexpr double kTouching_m = 1e-9;

// derived: the circumscribed pieces of two truncated cones, 0.08 m (1 / cos(pi / 64) - 1) each.
constexpr double kPieces_m = 2e-4;

struct Case {
  EngineKind engine;
  const CatalogueShape* a;
  const CatalogueShape* b;
};

std::vector<Case> AllCases() {
  std::vector<Case> cases;
  for (const EngineKind engine : {EngineKind::kExact, EngineKind::kFcl, EngineKind::kBullet}) {
    for (const CatalogueShape& a : Catalogue()) {
      for (const CatalogueShape& b : Catalogue()) {
        if (GetEngine(engine).Supports(KindOf(a.shape), KindOf(b.shape), QueryKind::kDistance)) {
          cases.push_back({engine, &a, &b});
        }
      }
    }
  }
  return cases;
}

std::string NameOfCase(const ::testing::TestParamInfo<Case>& info) {
  return std::string(NameOf(info.param.engine)) + info.param.a->name + info.param.b->name;
}

class EngineLaws : public ::testing::TestWithParam<Case> {
 protected:
  EngineLaws()
      : engine_(GetEngine(GetParam().engine)),
        a_(Place(engine_, GetParam().a->shape, Pose::Identity())),
        b_(Place(engine_, GetParam().b->shape, Pose::Identity())) {}

  // Draws the next placement, so near that about half of them overlap.
  void Next() {
    a_.X_WS = RandomPose(random_, 0.3);
    b_.X_WS = RandomPose(random_, GetParam().a->size_m + GetParam().b->size_m);
    b_.X_WS.translation() += a_.X_WS.translation();
  }
  PairDistance Measure() const { return engine_.Distance(a_.get(), b_.get(), kFar_m); }

  // True if the laws apply to the answer, which is not so for a best effort. Only some answers may
  // be best efforts, so that no engine passes by degrading everything: overlaps for Bullet,
  // overlaps of two half-spaces, and FCL's answers for a mesh and any shape except a sphere or a
  // mesh.
  bool CanJudge(const PairDistance& answer) const {
    if (answer.accuracy != Accuracy::kDegraded) return true;
    const ShapeKind kind_a = KindOf(GetParam().a->shape), kind_b = KindOf(GetParam().b->shape);
    const bool has_mesh = kind_a == ShapeKind::kMesh || kind_b == ShapeKind::kMesh;
    const bool both_endless = kind_a == ShapeKind::kHalfSpace && kind_b == kind_a;
    const bool has_sphere = kind_a == ShapeKind::kSphere || kind_b == ShapeKind::kSphere;
    const bool overlaps = answer.distance_m <= kTouching_m;
    EXPECT_TRUE((GetParam().engine == EngineKind::kBullet && overlaps) ||
                (both_endless && overlaps) ||
                (GetParam().engine == EngineKind::kFcl && has_mesh && !has_sphere &&
                 kind_a != kind_b && !overlaps))
        << answer.distance_m;
    return false;
  }

  std::mt19937 random_{20};
  const Engine& engine_;
  PlacedShape a_;
  PlacedShape b_;
};

TEST_P(EngineLaws, AnAnswerIsWellFormed) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    ASSERT_TRUE(std::isfinite(answer.distance_m));
    EXPECT_NEAR(answer.normal.norm(), 1, 1e-9);
    EXPECT_LT((answer.point_b - answer.point_a - answer.distance_m * answer.normal).norm(), 1e-7)
        << answer.distance_m;
    EXPECT_GE(answer.bound_m, 0);
    if (answer.accuracy == Accuracy::kExact) {
      EXPECT_EQ(answer.bound_m, 0);
    }
  }
}

TEST_P(EngineLaws, SwappingThePairReversesTheAnswer) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance ab = Measure();
    const PairDistance ba = engine_.Distance(b_.get(), a_.get(), kFar_m);
    if (!CanJudge(ab) || !CanJudge(ba)) continue;
    EXPECT_NEAR(ab.distance_m, ba.distance_m, Tolerance_m(ab) + Tolerance_m(ba));
  }
}

TEST_P(EngineLaws, ARigidMotionOfBothChangesNothing) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance before = Measure();
    const Pose X = RandomPose(random_, 1.0);
    a_.X_WS = X * a_.X_WS;
    b_.X_WS = X * b_.X_WS;
    const PairDistance after = Measure();
    if (!CanJudge(before) || !CanJudge(after)) continue;
    EXPECT_NEAR(before.distance_m, after.distance_m, Tolerance_m(before) + Tolerance_m(after));
  }
}

TEST_P(EngineLaws, CollidesMeansNegativeDistance) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (answer.distance_m > 0 && !CanJudge(answer)) continue;
    // Pairs near touching are skipped. Deeper overlaps are not, even if the bound on their depth
    // reaches 0, because the sign is still reliable.
    const double bound_m = answer.distance_m > 0 ? answer.bound_m : 0;
    if (std::abs(answer.distance_m) < kPieces_m + bound_m) continue;
    EXPECT_EQ(engine_.Collides(a_.get(), b_.get()), answer.distance_m < 0) << answer.distance_m;
  }
}

TEST_P(EngineLaws, ADistanceLimitIsRespected) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (answer.distance_m <= 0) continue;
    const double below_m = 0.5 * answer.distance_m;
    EXPECT_GT(engine_.Distance(a_.get(), b_.get(), below_m).distance_m, below_m);
    const double above_m = 1.5 * answer.distance_m + Tolerance_m(answer);
    const PairDistance limited = engine_.Distance(a_.get(), b_.get(), above_m);
    EXPECT_NEAR(limited.distance_m, answer.distance_m, 2 * Tolerance_m(answer));
  }
}

TEST_P(EngineLaws, ContactsContainTheDeepest) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    std::vector<PairDistance> contacts;
    const double margin_m = answer.distance_m + 0.01;
    engine_.Contacts(a_.get(), b_.get(), margin_m, 4, contacts);
    ASSERT_GE(contacts.size(), 1u);
    EXPECT_LE(contacts.size(), 4u);
    EXPECT_NEAR(contacts[0].distance_m, answer.distance_m, Tolerance_m(answer));
    contacts.clear();
    engine_.Contacts(a_.get(), b_.get(), answer.distance_m - 0.01 - answer.bound_m, 4, contacts);
    EXPECT_TRUE(contacts.empty());
  }
}

TEST_P(EngineLaws, SeparatedWitnessesLieOnTheSurfaces) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (answer.distance_m <= 0 || !CanJudge(answer)) continue;
    for (const auto& [placed, shape, point] :
         {std::tuple(&a_, &GetParam().a->shape, &answer.point_a),
          std::tuple(&b_, &GetParam().b->shape, &answer.point_b)}) {
      const double off_m = SignedDistance_m(*shape, placed->X_WS.inverse() * *point);
      EXPECT_NEAR(off_m, 0, kWitness_m + answer.bound_m);
    }
  }
}

// For convex shapes the answer can be proven: the gap along its normal equals its distance.
TEST_P(EngineLaws, TheNormalProvesTheDistanceOfConvexShapes) {
  const Shape& a = GetParam().a->shape;
  const Shape& b = GetParam().b->shape;
  if (!HasExtent(a) || !HasExtent(b)) GTEST_SKIP() << "not convex, or unbounded";
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (!CanJudge(answer)) continue;
    const double gap_m = Gap_m(a, a_.X_WS, b, b_.X_WS, answer.normal);
    EXPECT_NEAR(gap_m, answer.distance_m, 1e-6 + 2 * answer.bound_m);
  }
}

// No direction separates overlapping convex shapes by less than their depth, and none separates
// disjoint ones by more than their distance.
TEST_P(EngineLaws, NoOtherDirectionRefutesTheAnswer) {
  const Shape& a = GetParam().a->shape;
  const Shape& b = GetParam().b->shape;
  if (!HasExtent(a) || !HasExtent(b)) GTEST_SKIP() << "not convex, or unbounded";
  std::normal_distribution<double> normal;
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (!CanJudge(answer)) continue;
    for (int k = 0; k < 200; ++k) {
      Vector3 direction(normal(random_), normal(random_), normal(random_));
      if (k % 2 == 1) direction = answer.normal + 0.1 * direction;  // near the answer's own
      const double gap_m = Gap_m(a, a_.X_WS, b, b_.X_WS, direction.normalized());
      EXPECT_LE(gap_m, answer.distance_m + Tolerance_m(answer));
    }
  }
}

TEST_P(EngineLaws, MovingByTheDepthAlongTheNormalSeparates) {
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance answer = Measure();
    if (answer.distance_m >= 0 || answer.accuracy != Accuracy::kExact) continue;
    b_.X_WS.translation() -= answer.distance_m * answer.normal;
    const PairDistance after = Measure();
    EXPECT_NEAR(after.distance_m, 0, 1e-6 + after.bound_m);
  }
}

INSTANTIATE_TEST_SUITE_P(AllPairs, EngineLaws, ::testing::ValuesIn(AllCases()), NameOfCase);

}  // namespace
}  // namespace cwm::collision
