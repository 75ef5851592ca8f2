// The exact kernels, FCL and Bullet are three independent implementations: where the tables of
// trust let two of them answer, they agree within what they claim.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/contract/catalogue.h"

namespace cwm::collision {
namespace {

constexpr int kPlacements = 100;
constexpr double kFar_m = 1e3;
constexpr double kExact_m = 1e-7;  // what kExact means

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
        if (GetEngine(referee).Supports(kind_a, kind_b, Question::kCollides) &&
            GetEngine(EngineKind::kExact).Supports(kind_a, kind_b, Question::kCollides)) {
          cases.push_back({referee, &a, &b});
        }
      }
    }
  }
  return cases;
}

std::string NameOfCase(const testing::TestParamInfo<Case>& info) {
  return std::string(NameOf(info.param.referee)) + info.param.a->name + info.param.b->name;
}

class EngineAgreement : public testing::TestWithParam<Case> {
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
  // How far the circumscribed pieces and the tolerances of GJK reach.
  constexpr double kUndecided_m = 3e-4;
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const double distance_m = exact_.Distance(ours_.a.get(), ours_.b.get(), kFar_m).distance_m;
    if (std::abs(distance_m) < kUndecided_m) continue;
    EXPECT_EQ(referee_.Collides(theirs_.a.get(), theirs_.b.get()), distance_m < 0) << distance_m;
  }
}

TEST_P(EngineAgreement, OnDistanceWithinWhatTheyClaim) {
  const auto [kind, a, b] = GetParam();
  if (!referee_.Supports(KindOf(a->shape), KindOf(b->shape), Question::kDistance)) {
    GTEST_SKIP() << "yes and no only";
  }
  for (int i = 0; i < kPlacements; ++i) {
    Next();
    const PairDistance ours = exact_.Distance(ours_.a.get(), ours_.b.get(), kFar_m);
    const PairDistance theirs = referee_.Distance(theirs_.a.get(), theirs_.b.get(), kFar_m);
    if (ours.trust == Trust::kDegraded || theirs.trust == Trust::kDegraded) continue;
    EXPECT_NEAR(ours.distance_m, theirs.distance_m, kExact_m + ours.bound_m + theirs.bound_m);
  }
}

INSTANTIATE_TEST_SUITE_P(AllPairs, EngineAgreement, testing::ValuesIn(AllCases()), NameOfCase);

}  // namespace
}  // namespace cwm::collision
