// All contacts of a world, by hand and against the contacts of each of its objects.
#include "collision/query/get_world_contacts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <tuple>

#include "collision/query/attached_objects.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeChange;
using ::testing::UnorderedElementsAre;

Change Cube(const std::string& name, const Vector3& at_m, double margin_m = 0,
            const std::string& supported_by = "") {
  Change put =
      PutOf(name, {{.shape = Box{{1, 1, 1}}}}, MakeTranslation(at_m.x(), at_m.y(), at_m.z()));
  std::get<PutObject>(put.what).margin_m = margin_m;
  std::get<PutObject>(put.what).supported_by = supported_by;
  return put;
}

std::string NameAt(const WorldSnapshot& world, std::int32_t index) {
  return world.ObstacleAt(static_cast<std::size_t>(index)).name;
}

// The pairs of names, in the order of the answer.
std::vector<std::string> PairsOf(const WorldSnapshot& world,
                                 const QueryOptions& options = {.max_contacts = 1'000}) {
  const auto found = GetWorldContacts(world, options);
  EXPECT_TRUE(found.ok()) << found.status();
  std::vector<std::string> pairs;
  for (std::size_t i = 0; i < found->distance_m.size(); ++i) {
    pairs.push_back(NameAt(world, found->object_a[i]) + " " + NameAt(world, found->object_b[i]));
  }
  return pairs;
}

constexpr QueryOptions kAll{.max_contacts = 1'000};

TEST(WorldContacts, HaveDepthPointsAndNormalFromTheFirstName) {
  const auto world = WorldOf({Cube("b", {0, 0, 0}), Cube("a", {0.9, 0, 0}), Cube("c", {5, 0, 0})});
  const WorldContactColumns found = *GetWorldContacts(*world, kAll);
  ASSERT_EQ(found.distance_m.size(), 1u);
  EXPECT_EQ(NameAt(*world, found.object_a[0]), "a");
  EXPECT_EQ(NameAt(*world, found.object_b[0]), "b");
  EXPECT_NEAR(found.distance_m[0], -0.1, 1e-9);
  EXPECT_THAT(found.normal,
              ElementsAre(DoubleNear(-1, 1e-9), DoubleNear(0, 1e-9), DoubleNear(0, 1e-9)));
  EXPECT_NEAR(found.point_a[0], 0.4, 1e-9) << "the face of a that is deepest in b";
  EXPECT_NEAR(found.point_b[0], 0.5, 1e-9);
  EXPECT_THAT(found.part_a, ElementsAre(0));
  EXPECT_THAT(found.accuracy, ElementsAre(Accuracy::kExact));
  EXPECT_TRUE(found.is_complete);
}

TEST(WorldContacts, AreThoseNearerThanTheMarginsOfBothAndOfTheRequest) {
  const auto world = WorldOf({Cube("a", {0, 0, 0}, 0.1), Cube("b", {1.25, 0, 0}, 0.1)});
  EXPECT_THAT(PairsOf(*world), IsEmpty()) << "0.25 m apart";
  EXPECT_THAT(PairsOf(*world, {.margin_m = 0.04, .max_contacts = 9}), IsEmpty());
  EXPECT_THAT(PairsOf(*world, {.margin_m = 0.06, .max_contacts = 9}), ElementsAre("a b"));
}

TEST(WorldContacts, FollowTheRulesOfPairs) {
  const auto world =
      WorldOf({Cube("a", {0, 0, 0}), Cube("b", {1.25, 0, 0}), Cube("c", {0, 1.25, 0}),
               MakeChange(SetPairMargin{.pair = {{"a"}, {"*"}}, .margin_m = 0.3})});
  EXPECT_THAT(PairsOf(*world), ElementsAre("a b", "a c"));
  const auto allowed =
      *Apply(world, std::vector{MakeChange(AllowCollision{.pair = {{"c"}, {"a"}}})});
  EXPECT_THAT(PairsOf(*allowed), ElementsAre("a b"));
  QueryOptions ignoring = kAll;
  ignoring.ignore_pairs = {{{"b"}, {"*"}}};
  EXPECT_THAT(PairsOf(*world, ignoring), ElementsAre("a c"));
}

TEST(WorldContacts, LetWhatStandsReachIntoItsSupport) {
  const auto world = WorldOf({Cube("floor", {0, 0, 0}), Cube("mug", {0, 0, 0.996}, 0, "floor")});
  EXPECT_THAT(PairsOf(*world), IsEmpty()) << "4 mm deep, 5 mm are tolerated";
  EXPECT_THAT(PairsOf(*world, {.max_contacts = 9, .support_tolerance_m = 0.003}),
              ElementsAre("floor mug"));
}

TEST(WorldContacts, CanBeAskedOfSomeMembersAlone) {
  const auto world =
      WorldOf({Cube("a", {0, 0, 0}), Cube("b", {0.9, 0, 0}), Cube("c", {1.7, 0, 0})});
  EXPECT_THAT(PairsOf(*world), ElementsAre("b c", "a b"));
  QueryOptions options = kAll;
  options.only = {{"a"}};
  EXPECT_THAT(PairsOf(*world, options), ElementsAre("a b"));
  options.only = {{"c"}, {"b"}};
  EXPECT_THAT(PairsOf(*world, options), ElementsAre("b c", "a b"));
  options.only = {};
  options.ignore = {"c"};
  EXPECT_THAT(PairsOf(*world, options), ElementsAre("a b"));
}

TEST(WorldContacts, KeepTheDeepestOfTooMany) {
  const auto world = WorldOf({Cube("a", {0, 0, 0}), Cube("b", {0.9, 0, 0}), Cube("c", {1.7, 0, 0}),
                              Cube("d", {2.65, 0, 0})});
  const WorldContactColumns two = *GetWorldContacts(*world, {.max_contacts = 2});
  EXPECT_THAT(two.distance_m, ElementsAre(DoubleNear(-0.2, 1e-9), DoubleNear(-0.1, 1e-9)));
  EXPECT_FALSE(two.is_complete);
  EXPECT_TRUE(GetWorldContacts(*world, {.max_contacts = 3})->is_complete);
}

TEST(WorldContacts, AreIncompleteAfterTheDeadlineAndNoneOnceStopped) {
  const auto world = WorldOf({Cube("a", {0, 0, 0}), Cube("b", {0.9, 0, 0})});
  QueryOptions late = kAll;
  late.deadline = std::chrono::steady_clock::now() - std::chrono::seconds(1);
  EXPECT_FALSE(GetWorldContacts(*world, late)->is_complete);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(GetWorldContacts(*world, kAll, stop.get_token()).status().code(),
            absl::StatusCode::kCancelled);
}

// Each object asked about by itself gives the same pairs.
TEST(WorldContacts, EqualThoseOfEachObject) {
  std::mt19937 random(7);
  const auto world = RandomWorld(160, random, /*with_meshes=*/true);
  QueryOptions options = kAll;
  options.margin_m = 0.05;
  using Key = std::tuple<std::string, std::string, int, int>;
  std::map<Key, double> expected;
  for (const WorldObjectPtr& object : world->objects()) {
    const QueryBody body = BodyFromObject(*object);
    const PairColumns of_body =
        *GetContacts(*world, body, std::vector<Pose>{object->X_WO}, options);
    for (std::size_t i = 0; i < of_body.distance_m.size(); ++i) {
      const std::string other = NameAt(*world, of_body.object[i]);
      if (other < object->name) continue;
      const Key key{object->name, other, of_body.body_part[i], of_body.object_part[i]};
      const auto [at, is_new] = expected.try_emplace(key, of_body.distance_m[i]);
      if (!is_new) at->second = std::min(at->second, of_body.distance_m[i]);
    }
  }
  ASSERT_GT(expected.size(), 50u);
  const WorldContactColumns found = *GetWorldContacts(*world, options);
  EXPECT_EQ(found.distance_m.size(), expected.size());
  EXPECT_TRUE(std::ranges::is_sorted(found.distance_m));
  for (std::size_t i = 0; i < found.distance_m.size(); ++i) {
    const Key key{NameAt(*world, found.object_a[i]), NameAt(*world, found.object_b[i]),
                  found.part_a[i], found.part_b[i]};
    ASSERT_TRUE(expected.contains(key)) << std::get<0>(key) << " " << std::get<1>(key);
    EXPECT_EQ(found.distance_m[i], expected.at(key));
  }
  options.threads = 3;
  const WorldContactColumns again = *GetWorldContacts(*world, options);
  EXPECT_EQ(again.distance_m, found.distance_m);
  EXPECT_EQ(again.object_b, found.object_b);
  EXPECT_EQ(again.point_a, found.point_a);
}

// The arm of three balls of 0.1 m radius, a, c and e, 0.5 m apart along x, without an SRDF.
Change BallArm(double padding_m = 0) {
  const auto description = *ReadUrdf(testing::Robot(testing::ThreeBalls()), testing::NoMeshes);
  RobotModel model = **MakeRobotModel(description, nullptr);
  for (ModelLink& link : model.links) link.padding_m = link.name == "c" ? padding_m : 0;
  PutRobot put;
  put.name = "arm";
  put.robot = PrepareRobot(std::make_shared<const RobotModel>(model), std::nullopt);
  put.state = {0, 0};
  return MakeChange(put);
}

Change Bead(const std::string& name, const Vector3& at_m) {
  return PutOf(name, {{.shape = Sphere{0.05}}}, MakeTranslation(at_m.x(), at_m.y(), at_m.z()));
}

TEST(WorldContacts, OfARobotAreThoseOfItsLinksAndPaddings) {
  const auto world = WorldOf({BallArm(0.03), Bead("at_a", {0, 0.16, 0}),
                              Bead("at_c", {0.5, 0.16, 0}), Bead("in_e", {1, 0.14, 0})});
  const WorldContactColumns found = *GetWorldContacts(*world, kAll);
  EXPECT_THAT(PairsOf(*world), ElementsAre("arm in_e", "arm at_c"))
      << "a bead at 0.16 m is 1 cm from a ball, which only the padded one reaches";
  EXPECT_THAT(found.part_a, ElementsAre(2, 1));
  EXPECT_THAT(found.distance_m, ElementsAre(DoubleNear(-0.01, 1e-9), DoubleNear(0.01, 1e-9)));
}

TEST(WorldContacts, HaveTheCheckedSelfPairsOfRobots) {
  auto world = WorldOf({BallArm(0.5)});
  EXPECT_THAT(PairsOf(*world), IsEmpty()) << "paddings do not count between links";
  world = *Apply(
      world, std::vector{MakeChange(SetRobotState{
                 .name = "arm", .X_WB = {}, .joints = {.named = {}, .values = {{"elbow", 3}}}})});
  const WorldContactColumns found = *GetWorldContacts(*world, kAll);
  EXPECT_THAT(PairsOf(*world), ElementsAre("arm arm"));
  EXPECT_THAT(found.part_a, ElementsAre(0));
  EXPECT_THAT(found.part_b, ElementsAre(2));
  // e turns on a circle of 0.5 m about c: it comes to 2 * 0.5 * cos(1.5) of a.
  EXPECT_NEAR(found.distance_m[0], std::cos(1.5) - 0.2, 1e-9);
}

TEST(WorldContacts, LeaveOutWhatARobotCarriesAndItsTouchLinks) {
  const auto attach = [](const std::string& name, std::vector<std::string> touch) {
    return MakeChange(
        AttachObject{.name = name, .robot = "arm", .link = "e", .touch_links = std::move(touch)});
  };
  auto world = WorldOf({BallArm(), Cube("held", {1, 0.55, 0}), Cube("box", {1, 1.5, 0})});
  EXPECT_THAT(PairsOf(*world), UnorderedElementsAre("arm held", "arm held", "box held"))
      << "the balls c and e are in the cube";
  world = *Apply(world, std::vector{attach("held", {})});
  EXPECT_THAT(PairsOf(*world), UnorderedElementsAre("arm held", "box held"))
      << "ball c may not touch it";
  world = *Apply(world, std::vector{attach("held", {"c"})});
  EXPECT_THAT(PairsOf(*world), ElementsAre("box held"));
  world = *Apply(world, std::vector{attach("box", {})});
  EXPECT_THAT(PairsOf(*world), IsEmpty()) << "both are on one link";
}

}  // namespace
}  // namespace cwm::collision
