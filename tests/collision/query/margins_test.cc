// Distances of exactly the margin, with exact numbers: a collision is strictly less than the
// margin.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;

TEST(Margins, OfExactlyTheDistanceAreKept) {
  const auto world = WorldOf({PutOf("box", {{.shape = Box{{1, 1, 1}}}}, Pose::Identity())});
  const QueryBody ball = BodyFromShapes({{.shape = Sphere{0.25}}});
  const std::vector<Pose> poses = {MakeTranslation(1, 0, 0),
                                   MakeTranslation(std::nextafter(1, 0), 0, 0)};
  for (const EngineChoice engine : {EngineChoice::kAuto, EngineChoice::kExact}) {
    const QueryOptions options{.engine = engine, .margin_m = 0.25};
    const auto result = *CheckCollisions(*world, ball, PoseRows(poses), options);
    EXPECT_THAT(result.verdict, ElementsAre(Verdict::kFree, Verdict::kCollision));
    EXPECT_THAT(GetContacts(*world, ball, PoseRows(poses), options)->row_begin,
                ElementsAre(0, 0, 1));
  }
}

// The depth is not measured, which for a mesh would only be bounded.
TEST(Margins, LeaveAsCertainWhatOverlapsAnyway) {
  const auto world = WorldOf({PutOf("mesh", {{.shape = MakeMesh(ElbowMesh())}}, Pose::Identity())});
  const QueryBody ball = BodyFromShapes({{.shape = Sphere{0.25}}});
  const std::vector<Pose> poses = {MakeTranslation(0.3, -0.06, 0), MakeTranslation(0.4, -0.06, 0),
                                   MakeTranslation(0, 0, 0)};
  for (const double margin_m : {0.0, 0.01, 0.1}) {
    const auto result = *CheckCollisions(*world, ball, PoseRows(poses), {.margin_m = margin_m});
    EXPECT_THAT(result.verdict, ElementsAre(Verdict::kCollision,
                                            margin_m < 0.05 ? Verdict::kFree : Verdict::kCollision,
                                            Verdict::kCollision));
    EXPECT_THAT(result.accuracy, Each(Accuracy::kExact)) << margin_m;
  }
}

TEST(Margins, LetWhatStandsReachExactlyAsDeepAsTheTolerance) {
  Change put = PutOf("cube", {{.shape = Box{{1, 1, 1}}}}, Pose::Identity());
  std::get<PutObject>(put.what).supported_by = "floor";
  const auto world =
      WorldOf({put, PutOf("floor", {{.shape = Box{{4, 4, 1}}}}, MakeTranslation(0, 0, -0.5))});
  const QueryBody cube = BodyFromObject(*world->Find("cube"));
  const double deep_m = 0.0078125;
  const std::vector<Pose> poses = {MakeTranslation(0, 0, 0.5 - deep_m),
                                   MakeTranslation(0, 0, 0.5 - deep_m - 0x1p-40)};
  const QueryOptions options{.support_tolerance_m = deep_m};
  EXPECT_THAT(CheckCollisions(*world, cube, PoseRows(poses), options)->verdict,
              ElementsAre(Verdict::kFree, Verdict::kCollision));
}

}  // namespace
}  // namespace cwm::collision
