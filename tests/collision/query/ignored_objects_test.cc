// Queries that ignore objects by name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Not;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(IgnoredObjects, AndTheOneThatAsksAreLeftOut) {
  const auto world = WorldOf(
      {PutOf("a", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(0, 0, 0)),
       PutOf("b", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(1, 0, 0)),
       PutOf("c", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(2, 0, 0))});
  QueryOptions options;
  options.max_results = 9;
  options.ignore = {"b", "unknown"};
  const std::vector<Pose> at = {Pose::Identity()};
  const QueryBody body = BodyFromObject(*world->Find("a"));
  EXPECT_THAT(GetDistances(*world, body, at, options)->object, ElementsAre(2));
  EXPECT_EQ(CheckCollisions(*world, body, at, options)->verdict[0], Verdict::kFree);
  const std::vector<RayRow> rays = {{{-1, 0, 0}, {1, 0, 0}, kInfinity}};
  options.ignore = {"a", "b"};
  EXPECT_NEAR(CastRays(*world, rays, options)->distance_m[0], 2.9, 1e-12);
}

TEST(IgnoredObjects, AreLeftOutEachHoweverManyThereAre) {
  std::vector<Change> changes;
  QueryOptions options;
  options.max_results = 99;
  for (int k = 0; k < 60; ++k) {
    const std::string name = "ball_" + std::to_string(k);
    changes.push_back(
        PutOf(name, {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}}, MakeTranslation(k, 0, 0)));
    if (k % 3 != 0) options.ignore.push_back(name);
  }
  const auto world = WorldOf(changes);
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {Pose::Identity()};
  const auto near = GetDistances(*world, body, at, options);
  ASSERT_EQ(near->object.size(), 20u);
  for (const std::int32_t object : near->object) {
    const std::string& name = world->ObstacleAt(object).name;
    EXPECT_THAT(options.ignore, Not(Contains(name)));
  }
}

}  // namespace
}  // namespace cwm::collision
