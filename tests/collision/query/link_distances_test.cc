// Distances link by link (DistancePairs::kLinks): worked out by hand, and against all pairs of
// parts measured one by one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "collision/query/query.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/query/rod_arm.h"

namespace cwm::collision {
namespace {

using ::testing::DoubleNear;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Pointwise;

PairColumns Distances(const RodArmStates& arm, const WorldSnapshot& world, int max_results,
                      double max_distance_m) {
  return *GetDistances(world, arm.body, arm.Rows(),
                       {.max_distance_m = max_distance_m,
                        .pairs = DistancePairs::kLinks,
                        .max_results = max_results});
}

TEST(LinkDistances, AreThoseOfEachLinkWithinTheRadius) {
  const auto world = WorldOf({PutRodArm(), BallAt("v", {1.2, 0.3, 0}), BallAt("w", {0.5, 0.3, 0})});
  const PairColumns near = Distances(RodArmStates(*world), *world, 0, 0.5);
  const double base_to_w_m = std::hypot(0.4, 0.2) - 0.05;  // from the box's edge at (0.1, 0.1)
  const double hand_to_v_m = std::hypot(0.2, 0.3) - 0.1, hand_to_w_m = std::hypot(0.5, 0.3) - 0.1;
  EXPECT_THAT(near.distance_m, AreNear({0.35, base_to_w_m, 0.2, 0.4, hand_to_v_m, hand_to_w_m}));
  EXPECT_THAT(near.body_part, ElementsAre(0, 0, 1, 1, 2, 2));
  EXPECT_THAT(near.object, ElementsAre(kSelfObject, 1, 1, kSelfObject, 0, 1));
  EXPECT_THAT(near.object_part, ElementsAre(1, 0, 0, 2, 0, 0));
  EXPECT_THAT(near.row_begin, ElementsAre(0, 6));
}

TEST(LinkDistances, AreTheNearestOfEachLink) {
  const auto world = WorldOf({PutRodArm(), BallAt("v", {1.2, 0.3, 0}), BallAt("w", {0.5, 0.3, 0})});
  const double hand_to_v_m = std::hypot(0.2, 0.3) - 0.1;
  const double infinity_m = std::numeric_limits<double>::infinity();
  const PairColumns near = Distances(RodArmStates(*world), *world, 1, infinity_m);
  EXPECT_THAT(near.distance_m, AreNear({0.35, 0.2, hand_to_v_m}));
  EXPECT_THAT(near.body_part, ElementsAre(0, 1, 2));
  EXPECT_EQ(Distances(RodArmStates(*world), *world, 9, infinity_m).distance_m.size(), 9u);
}

TEST(LinkDistances, CountAnAttachedObjectAsALinkOfItsOwn) {
  std::vector<Change> changes = HeldBox();
  changes.insert(changes.begin(), PutRodArm());
  const auto world = WorldOf(changes);
  const PairColumns near = Distances(RodArmStates(*world), *world, 0, 0.7);
  // base - rod, rod - hand, rod - box; the hand may touch the box. The box has the last part.
  EXPECT_THAT(near.distance_m, AreNear({0.35, 0.4, 0.6}));
  EXPECT_THAT(near.body_part, ElementsAre(0, 1, 1));
  EXPECT_THAT(near.object_part, ElementsAre(1, 2, 3));
  EXPECT_THAT(near.object, Each(kSelfObject));
  EXPECT_THAT(std::vector<double>(near.normal.begin() + 6, near.normal.end()),
              AreNear({1, 0, 0}));  // from the rod to the box
}

TEST(LinkDistances, TellEachLinkOfAnotherRobotToABody) {
  const auto world = WorldOf({PutRodArm()});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.05}}});
  const std::vector<Pose> at = {MakeTranslation(0.5, 0.3, 0)};
  const PairColumns near = *GetDistances(
      *world, body, at, {.max_distance_m = 1, .pairs = DistancePairs::kLinks, .max_results = 0});
  EXPECT_THAT(near.distance_m,
              AreNear({0.2, std::hypot(0.4, 0.2) - 0.05, std::hypot(0.5, 0.3) - 0.1}));
  EXPECT_THAT(near.object_part, ElementsAre(1, 0, 2));
}

TEST(LinkDistances, OfMoreThanTheAllowedAnswersAreRefused) {
  const auto world = WorldOf({PutRodArm(), BallAt("v", {1.2, 0.3, 0}), BallAt("w", {0.5, 0.3, 0})});
  const RodArmStates arm(*world);
  const JointRows rows = arm.Rows();
  QueryOptions options{.max_distance_m = 0.5, .pairs = DistancePairs::kLinks, .max_results = 0};
  options.max_answers = 6;
  EXPECT_TRUE(GetDistances(*world, arm.body, rows, options).ok());
  options.max_answers = 5;
  EXPECT_EQ(GetDistances(*world, arm.body, rows, options).status().code(),
            absl::StatusCode::kOutOfRange);
}

// A frame of the body, the index of the object (or kSelfObject), and its link or frame.
using GroupName = std::tuple<int, int, int>;

// The least distance of each group, from all pairs of parts.
std::map<GroupName, double> BruteDistances(const WorldSnapshot& world, const RodArmStates& arm) {
  const Engine& exact = GetEngine(EngineKind::kExact);
  std::vector<Pose> X_WF(static_cast<std::size_t>(arm.body.TotalFrames()));
  arm.Rows().Place(0, std::span(X_WF).first(3));
  for (std::size_t k = 0; k < arm.body.attached.size(); ++k) {
    const AttachedObject& attached = arm.body.attached[k];
    X_WF[3 + k] = X_WF[static_cast<std::size_t>(attached.link)] * attached.X_FO;
  }
  std::map<GroupName, double> least_m;
  const auto add = [&](const GroupName& name, const PreparedPart& a, const Pose& X_WA,
                       const PreparedPart& b, const Pose& X_WB) {
    const double distance_m = exact
                                  .Distance({KindOf(a.shape), *a.engines[0], X_WA},
                                            {KindOf(b.shape), *b.engines[0], X_WB},
                                            std::numeric_limits<double>::infinity())
                                  .distance_m;
    const auto [at, is_new] = least_m.try_emplace(name, distance_m);
    at->second = std::min(at->second, distance_m);
  };
  const std::vector<PreparedPart>& parts = arm.body.geometry->parts;
  const auto pose_of = [&](std::size_t part) -> Pose {
    return X_WF[static_cast<std::size_t>(arm.body.FrameOf(static_cast<std::int32_t>(part)))] *
           parts[part].X_OP;
  };
  for (const auto& [first, second] : arm.body.self_pairs) {
    const auto low = static_cast<std::size_t>(std::min(first, second));
    const auto high = static_cast<std::size_t>(std::max(first, second));
    add({arm.body.FrameOf(static_cast<int>(low)), kSelfObject,
         arm.body.FrameOf(static_cast<int>(high))},
        parts[low], pose_of(low), parts[high], pose_of(high));
  }
  const std::size_t count = world.objects().size() + world.robots().size();
  for (std::size_t index = 0; index < count; ++index) {
    const Obstacle& object = world.ObstacleAt(index);
    if (arm.body.IsNamed(object.name)) continue;
    for (std::size_t b = 0; b < parts.size(); ++b) {
      for (std::size_t o = 0; o < object.parts_W.size(); ++o) {
        const int link = object.robot ? object.robot->link_of_part[o] : 0;
        add({arm.body.FrameOf(static_cast<int>(b)), static_cast<int>(index), link}, parts[b],
            pose_of(b), object.geometry->parts[o], object.parts_W[o].X_WP);
      }
    }
  }
  return least_m;
}

TEST(LinkDistances, AreThoseOfAllPairsOfParts) {
  std::mt19937 random(11);
  std::vector<Change> changes = {PutRodArm(), PutRodArm("other", MakeTranslation(0.3, 0.4, 0))};
  for (const Change& change : HeldBox()) changes.push_back(change);
  for (int k = 0; k < 10; ++k) {
    changes.push_back(PutOf("object_" + std::to_string(k),
                            {{.X_FS = RandomPose(random, 0.2), .shape = Box{{0.1, 0.2, 0.1}}},
                             {.X_FS = RandomPose(random, 0.2), .shape = Capsule{0.03, 0.2}}},
                            RandomPose(random, 1.0)));
  }
  const auto world = WorldOf(changes);
  std::uniform_real_distribution<double> turn(-3, 3), grip(-1, 0.5);
  constexpr double kRadius_m = 0.4;
  int overlaps = 0;
  for (int k = 0; k < 50; ++k) {
    RodArmStates arm(*world);
    arm.rows = {turn(random), grip(random)};
    std::map<GroupName, double> expected = BruteDistances(*world, arm);
    const auto name_of = [&](const PairColumns& columns, std::size_t i) -> GroupName {
      const int part = columns.object_part[i], frame = arm.body.FrameOf(columns.body_part[i]);
      if (columns.object[i] == kSelfObject) return {frame, kSelfObject, arm.body.FrameOf(part)};
      const Obstacle& object = world->ObstacleAt(static_cast<std::size_t>(columns.object[i]));
      const int link =
          object.robot ? object.robot->link_of_part[static_cast<std::size_t>(part)] : 0;
      return {frame, columns.object[i], link};
    };
    const PairColumns within = Distances(arm, *world, 0, kRadius_m);
    for (std::size_t i = 0; i < within.distance_m.size(); ++i) {
      EXPECT_NEAR(within.distance_m[i], expected.at(name_of(within, i)), 1e-7);
      overlaps += within.distance_m[i] < 0 ? 1 : 0;
    }
    const auto count =
        std::ranges::count_if(expected, [](const auto& each) { return each.second <= kRadius_m; });
    EXPECT_EQ(within.distance_m.size(), static_cast<std::size_t>(count));
    // The three nearest of each frame.
    const PairColumns nearest = Distances(arm, *world, 3, std::numeric_limits<double>::infinity());
    std::map<int, std::vector<double>> by_frame;
    for (const auto& [name, distance_m] : expected) {
      by_frame[std::get<0>(name)].push_back(distance_m);
    }
    std::vector<double> expected_m;
    for (auto& [frame, distances_m] : by_frame) {
      std::ranges::sort(distances_m);
      distances_m.resize(3);
      expected_m.insert(expected_m.end(), distances_m.begin(), distances_m.end());
    }
    EXPECT_THAT(nearest.distance_m, Pointwise(DoubleNear(1e-7), expected_m));
  }
  EXPECT_GT(overlaps, 10);
}

}  // namespace
}  // namespace cwm::collision
