// Distances of bodies with many parts: the nearest pair must not depend on the order of evaluation.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

constexpr double kFar_m = std::numeric_limits<double>::infinity();

void AskAllPairs(QueryBody& body) {
  const auto count = static_cast<std::int32_t>(body.geometry->parts.size());
  for (std::int32_t a = 0; a < count; ++a) {
    for (std::int32_t b = a + 1; b < count; ++b) body.self_pairs.push_back({a, b});
  }
}

double PartsApart_m(const QueryBody& body, const PartPair& pair, const Pose& X_WB) {
  const PreparedPart& a = body.geometry->parts[static_cast<std::size_t>(pair.first)];
  const PreparedPart& b = body.geometry->parts[static_cast<std::size_t>(pair.second)];
  const Pose X_WP = X_WB * a.X_OP, X_WQ = X_WB * b.X_OP;
  return GetEngine(EngineKind::kExact)
      .Distance({KindOf(a.shape), *a.engines[0], X_WP}, {KindOf(b.shape), *b.engines[0], X_WQ},
                kFar_m)
      .distance_m;
}

TEST(NearestFirst, TheNearestPartsOfABodyAreThoseOfBruteForce) {
  std::mt19937 random(23);
  int apart = 0, overlapping = 0;
  for (int k = 0; k < 60; ++k) {
    std::vector<Placed<>> shapes;
    for (int part = 0; part < 12; ++part) {
      const Shape kinds[] = {Box{{0.2, 0.05, 0.1}}, MakeMesh(Tessellate(Shape(Sphere{0.08}), 2e-3)),
                             Capsule{0.03, 0.2}};
      shapes.push_back(
          {.X_FS = RandomPose(random, k % 2 == 0 ? 1.5 : 0.6), .shape = kinds[part % 3]});
    }
    QueryBody body = BodyFromShapes(std::move(shapes));
    body.tests_world = false;
    AskAllPairs(body);
    const std::vector<Pose> X_WB = {RandomPose(random, 1.0)};
    const PairColumns result = *GetDistances(WorldSnapshot(), body, X_WB, {});
    ASSERT_EQ(result.distance_m.size(), 1u);
    double min_m = kFar_m;
    for (const PartPair& pair : body.self_pairs) {
      min_m = std::min(min_m, PartsApart_m(body, pair, X_WB[0]));
    }
    ++(min_m < 0 ? overlapping : apart);
    EXPECT_NEAR(result.distance_m[0], min_m, 1e-7);
    const PartPair named{result.body_part[0], result.object_part[0]};
    EXPECT_NEAR(PartsApart_m(body, named, X_WB[0]), min_m, 1e-7);
  }
  EXPECT_GT(apart, 10);
  EXPECT_GT(overlapping, 10);
}

TEST(NearestFirst, OfEquallyNearPartsTheFirstAreNamed) {
  // Balls in a row with equal gaps between neighbours; the last pair of them comes first.
  std::vector<Placed<>> balls;
  for (int k = 0; k < 6; ++k) {
    balls.push_back({.X_FS = MakeTranslation(0.5 * k, 0, 0), .shape = Sphere{0.125}});
  }
  QueryBody body = BodyFromShapes(balls);
  body.tests_world = false;
  AskAllPairs(body);
  std::reverse(body.self_pairs.begin(), body.self_pairs.end());
  const std::vector<Pose> at = {Pose::Identity()};
  const PairColumns itself = *GetDistances(WorldSnapshot(), body, at, {});
  EXPECT_EQ(itself.body_part[0], 0);
  EXPECT_EQ(itself.object_part[0], 1);
}

TEST(NearestFirst, OfEquallyNearObjectsTheFirstByNameAreNamed) {
  // Each ball of the body has a ball straight above it, added in reverse order of their names.
  std::vector<Placed<>> balls;
  std::vector<Change> changes;
  for (int k = 0; k < 6; ++k) {
    const Pose X_FS = MakeTranslation(0.5 * k, 0, 0);
    balls.push_back({.X_FS = X_FS, .shape = Sphere{0.125}});
    changes.push_back(PutOf("ball" + std::to_string(5 - k),
                            {{.X_FS = Pose::Identity(), .shape = Sphere{0.125}},
                             {.X_FS = MakeTranslation(0, 0, 4), .shape = Sphere{0.125}}},
                            MakeTranslation(0.5 * k, 0, 2)));
  }
  const auto world = WorldOf(changes);
  const QueryBody body = BodyFromShapes(balls);
  const std::vector<Pose> at = {Pose::Identity()};
  for (const int results : {1, 3, 6}) {
    QueryOptions options;
    options.max_results = results;
    const PairColumns result = *GetDistances(*world, body, at, options);
    ASSERT_EQ(result.object.size(), static_cast<std::size_t>(results));
    for (int k = 0; k < results; ++k) {
      EXPECT_EQ(result.object[static_cast<std::size_t>(k)], k);
      EXPECT_EQ(result.body_part[static_cast<std::size_t>(k)], 5 - k);
      EXPECT_EQ(result.object_part[static_cast<std::size_t>(k)], 0);
      EXPECT_EQ(result.distance_m[static_cast<std::size_t>(k)], 1.75);
    }
  }
}

}  // namespace
}  // namespace cwm::collision
