#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::HasSubstr;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(CastRays, ARayEndsAtTheFirstSurfaceAndTheWayThereIsFree) {
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::mt19937 random(42);
  const auto world = RandomWorld(30, random, /*with_meshes=*/true);
  std::vector<RayRow> rays;
  for (int i = 0; i < 300; ++i) {
    // From random origins, aimed at one of the objects with an error of a few centimetres.
    const Vector3 origin = RandomPose(random, 1.5).translation();
    const Vector3 target = world->objects()[i % world->objects().size()]->X_WO.translation() +
                           RandomPose(random, 0.05).translation();
    rays.push_back({origin, (target - origin).normalized(), i % 2 == 0 ? kInfinity : 0.7});
  }
  const RayColumns columns = *CastRays(*world, rays, {});
  ASSERT_EQ(columns.completed, rays.size());
  int hits = 0;
  // A hit is on the surface of the named object, and nothing is in front of it: a thin sphere that
  // moves along the ray is free of every object up to there.
  for (std::size_t i = 0; i < rays.size(); ++i) {
    const double clear_m =
        columns.hit[i] ? columns.distance_m[i] : std::min(3.0, rays[i].max_distance_m);
    if (columns.hit[i]) {
      ++hits;
      EXPECT_LE(columns.distance_m[i], rays[i].max_distance_m);
      const WorldObject& object = *world->objects()[columns.object[i]];
      const PreparedPart& part = object.geometry->parts[columns.object_part[i]];
      const Pose X_WS = object.X_WO * part.X_OP;
      const PlacedShape tip = Place(
          exact, Sphere{1e-6},
          Pose(Eigen::Translation3d(rays[i].origin + columns.distance_m[i] * rays[i].direction)));
      const double off_m =
          exact.Distance(tip.get(), {KindOf(part.shape), *part.engines[0], X_WS}, kInfinity)
              .distance_m;
      EXPECT_NEAR(off_m, 0, 1e-5);
      const Eigen::Map<const Vector3> normal(&columns.normal[3 * i]);
      EXPECT_NEAR(normal.norm(), 1, 1e-9);
    } else {
      EXPECT_EQ(columns.distance_m[i], 0);
    }
    std::vector<Pose> along;
    for (double t = 0; t < clear_m - 1e-3; t += 0.01) {
      along.emplace_back(Eigen::Translation3d(rays[i].origin + t * rays[i].direction));
    }
    // Only for rays from outside: rays that start inside a solid hit its far side.
    const QueryBody tip = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{1e-9}}});
    const auto verdicts = CheckCollisions(*world, tip, along, {})->verdict;
    if (verdicts.empty() || verdicts[0] == Verdict::kCollision) continue;
    EXPECT_THAT(verdicts, ::testing::Each(Verdict::kFree));
  }
  EXPECT_GT(hits, 30);
}

TEST(CastRays, AnEngineThatMeasuresNoRaysIsRefusedByName) {
  const auto world = WorldOf({PutOf("ball", {{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}},
                                    MakeTranslation(1, 0, 0))});
  const std::vector<RayRow> rays = {{Vector3::Zero(), Vector3::UnitX()}};
  QueryOptions options;
  for (const EngineChoice engine : {EngineChoice::kAuto, EngineChoice::kExact}) {
    options.engine = engine;
    EXPECT_NEAR(CastRays(*world, rays, options)->distance_m[0], 0.9, 1e-12);
  }
  for (const auto& [engine, name] :
       {std::pair(EngineChoice::kFcl, "FCL"), std::pair(EngineChoice::kBullet, "BULLET")}) {
    options.engine = engine;
    const absl::Status status = CastRays(*world, rays, options).status();
    EXPECT_EQ(status.code(), absl::StatusCode::kUnimplemented);
    EXPECT_THAT(std::string(status.message()), HasSubstr(name));
  }
}

}  // namespace
}  // namespace cwm::collision
