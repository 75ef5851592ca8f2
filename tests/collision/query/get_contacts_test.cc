#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>
#include <vector>

#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"

namespace cwm::collision {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::SizeIs;

constexpr double kDepth_m = 1e-3;
constexpr double kRounding_m = 1e-12;

using PairName = std::tuple<std::int32_t, std::int32_t, std::int32_t>;
PairName PairOf(const PairColumns& columns, std::size_t k) {
  return {columns.object[k], columns.body_part[k], columns.object_part[k]};
}

// The distances of all pairs below the margin, computed one by one without a broad phase, deepest
// first.
std::vector<double> BruteDepths(const WorldSnapshot& world, const QueryBody& body, const Pose& X_WB,
                                double margin_m) {
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::vector<double> depths;
  for (const WorldObjectPtr& object : world.objects()) {
    for (const PreparedPart& mine : body.geometry->parts) {
      for (const PreparedPart& theirs : object->geometry->parts) {
        const Pose X_WP = X_WB * mine.X_OP, X_WQ = object->X_WO * theirs.X_OP;
        const double distance_m = exact
                                      .Distance({KindOf(mine.shape), *mine.engines[0], X_WP},
                                                {KindOf(theirs.shape), *theirs.engines[0], X_WQ}, 1)
                                      .distance_m;
        if (distance_m < margin_m) depths.push_back(distance_m);
      }
    }
  }
  std::sort(depths.begin(), depths.end());
  return depths;
}

TEST(GetContacts, TellsTheDeepestOfEachPairBeforeFurtherPointsOfAny) {
  std::mt19937 random(42);
  const auto world = RandomWorld(30, random, /*with_meshes=*/true);
  const QueryBody body = Gripper();
  std::vector<Pose> poses = RandomPoses(150, random);
  for (const WorldObjectPtr& object : world->objects()) {  // aligned with one of its parts
    poses.push_back(object->X_WO * object->geometry->parts[0].X_OP * MakeTranslation(0, 0, 0.06));
  }
  QueryOptions options{.margin_m = 0.05, .max_contacts = 4};
  const PairColumns columns = *GetContacts(*world, body, poses, options);
  std::size_t further = 0;
  for (std::size_t row = 0; row < poses.size(); ++row) {
    const auto expected = BruteDepths(*world, body, poses[row], options.margin_m);
    const std::size_t begin = columns.row_begin[row], end = columns.row_begin[row + 1];
    ASSERT_LE(end - begin, 4u);
    ASSERT_GE(end - begin, std::min<std::size_t>(4, expected.size()));
    std::set<PairName> seen;
    for (std::size_t k = begin; k < end; ++k) {
      EXPECT_GE(columns.distance_m[k], columns.distance_m[k > begin ? k - 1 : k]);
      EXPECT_LT(columns.distance_m[k], options.margin_m);
      if (!seen.insert(PairOf(columns, k)).second) {
        ++further;
        continue;
      }
      EXPECT_NEAR(columns.distance_m[k], expected[seen.size() - 1], 1e-7);
    }
    EXPECT_EQ(seen.size(), std::min<std::size_t>(4, expected.size()));
  }
  EXPECT_GT(further, 20u);
}

const QueryBody kBlock =
    BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Box{{0.2, 0.1, 0.3}}}});

TEST(GetContacts, OfABoxOnAFloorAreItsCorners) {
  const auto world = WorldOf(
      {PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}}, Pose::Identity())});
  const std::vector<Pose> at = {MakeTranslation(0.4, 0, 0.15 - kDepth_m),
                                MakeTranslation(0.4, 0, 0.15 + kDepth_m)};
  const PairColumns columns = *GetContacts(*world, kBlock, at, {});
  EXPECT_THAT(columns.row_begin, ElementsAre(0, 4, 4));
  EXPECT_THAT(columns.distance_m, Each(::testing::DoubleNear(-kDepth_m, kRounding_m)));
  std::set<std::pair<int, int>> corners;  // in centimetres
  for (std::size_t k = 0; k < 4; ++k) {
    // The normal points from the block down to the floor.
    EXPECT_EQ(columns.normal[3 * k + 2], -1);
    EXPECT_NEAR(columns.point_body[3 * k + 2], -kDepth_m, kRounding_m);
    EXPECT_NEAR(columns.point_object[3 * k + 2], 0, kRounding_m);
    corners.emplace(std::lround(100 * columns.point_body[3 * k]),
                    std::lround(100 * columns.point_body[3 * k + 1]));
  }
  EXPECT_THAT(corners, ElementsAre(std::pair(30, -5), std::pair(30, 5), std::pair(50, -5),
                                   std::pair(50, 5)));
}

// A block in the corner of a floor and a wall, less deep in the wall.
TEST(GetContacts, FurtherPointsOfOnePairPushOutNoOther) {
  const auto world =
      WorldOf({PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}}, Pose::Identity()),
               PutOf("wall", {{.X_FS = MakeTranslation(-0.5, 0, 0), .shape = Box{{1, 4, 4}}}},
                     Pose::Identity())});
  const std::vector<Pose> at = {MakeTranslation(0.1 - 0.5 * kDepth_m, 0, 0.15 - kDepth_m)};
  const std::size_t all = GetContacts(*world, kBlock, at, {})->object.size();
  EXPECT_GE(all, 8u);
  for (const int most : {1, 2, 3, 5, 16}) {
    const PairColumns columns = *GetContacts(*world, kBlock, at, {.max_contacts = most});
    EXPECT_EQ(columns.object[0], 0);
    EXPECT_EQ(std::ranges::count(columns.object, 1) > 0, most > 1) << most;
    EXPECT_TRUE(std::is_sorted(columns.distance_m.begin(), columns.distance_m.end()));
    EXPECT_THAT(columns.object, SizeIs(std::min(static_cast<std::size_t>(most), all)));
  }
}

TEST(GetContacts, OfOtherEnginesAreOneAPair) {
  const auto world = WorldOf(
      {PutOf("table", {{.X_FS = Pose::Identity(), .shape = Box{{2, 2, 0.2}}}}, Pose::Identity())});
  const std::vector<Pose> at = {MakeTranslation(0, 0, 0.25 - kDepth_m)};
  for (const EngineChoice engine : {EngineChoice::kFcl, EngineChoice::kBullet}) {
    EXPECT_EQ(GetContacts(*world, kBlock, at, {.engine = engine})->row_begin[1], 1u);
  }
  EXPECT_GE(GetContacts(*world, kBlock, at, {.engine = EngineChoice::kExact})->row_begin[1], 4u);
}

}  // namespace
}  // namespace cwm::collision
