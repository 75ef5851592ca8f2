// The content of a scene besides its objects: the robot, allowed collisions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clients/formats/scene_file.h"
#include "server/core/error.h"
#include "server/export/moveit_scene.h"
#include "server/export/scene_numbers.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::server {
namespace {

using collision::AllowCollision;
using collision::Change;
using collision::NamedPair;
using collision::WorldSnapshot;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Change Allow(NamedPair pair) { return {AllowCollision{.pair = std::move(pair)}, std::nullopt}; }

std::shared_ptr<const WorldSnapshot> WorldWith(const std::vector<Change>& changes) {
  auto world = Apply(std::make_shared<const WorldSnapshot>(), changes);
  EXPECT_TRUE(world.ok()) << world.status();
  return *world;
}

formats::SceneFile Read(const PlanningScene& scene) {
  const auto read = formats::ParseScene(FormatSceneYaml(scene).value(), "exported");
  EXPECT_TRUE(read.ok()) << read.status();
  return *read;
}

bool IsAllowed(const formats::SceneFile& scene, const std::string& a, const std::string& b) {
  const auto& names = scene.allowed_collisions.names;
  const auto at = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  EXPECT_LT(at(a), names.size()) << a;
  EXPECT_LT(at(b), names.size()) << b;
  EXPECT_EQ(scene.allowed_collisions.allowed[at(a)][at(b)],
            scene.allowed_collisions.allowed[at(b)][at(a)]);
  return scene.allowed_collisions.allowed[at(a)][at(b)];
}

TEST(PlanningSceneTest, SaysWhereTheRobotIsToTheLastBit) {
  auto arm = collision::testing::PutArm("crane");
  arm.X_WB = MakePose({0.1, 1.0 / 3, -1e-7}, Quaternion(0.6, 0, 0, 0.8));
  arm.state[0] = 1.0 / 3;
  const auto world = WorldWith({{arm, std::nullopt}});
  auto scene = MakePlanningScene(*world, 0);
  ASSERT_TRUE(scene.ok());
  ASSERT_TRUE(AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene).ok());
  const formats::SceneFile read = Read(*scene);
  EXPECT_EQ(read.robot_model_name, "arm");
  ASSERT_EQ(read.robot_state.joints.size(), 3u);
  EXPECT_EQ(read.robot_state.joints[0].name, "elbow");
  EXPECT_EQ(read.robot_state.joints[0].position, 1.0 / 3);
  ASSERT_EQ(read.robot_state.multi_dof_joints.size(), 2u);
  EXPECT_THAT(read.robot_state.multi_dof_joints[0].transform.position_m,
              ElementsAre(0.1, 1.0 / 3, -1e-7));
  EXPECT_EQ(read.robot_state.multi_dof_joints[1].name, "float");
  EXPECT_TRUE(formats::IsIdentity(read.robot_state.multi_dof_joints[1].transform));
}

TEST(PlanningSceneTest, AllowsWhatRulesAndTheRobotAllow) {
  const auto world = WorldWith({{collision::testing::PutArm("crane"), std::nullopt},
                                Allow({{"crane", "tip"}, {"cup"}}),
                                Allow({{"cup"}, {"tray"}}),
                                Allow({{"crane", "base"}, {"*"}})});
  auto scene = MakePlanningScene(*world, 0);
  ASSERT_TRUE(AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene).ok());
  const formats::SceneFile read = Read(*scene);
  EXPECT_THAT(read.allowed_collisions.names, ElementsAre("base", "cup", "tip", "tray", "upper"));
  EXPECT_TRUE(IsAllowed(read, "tip", "cup"));
  EXPECT_TRUE(IsAllowed(read, "cup", "tray"));
  EXPECT_FALSE(IsAllowed(read, "tip", "tray"));
  EXPECT_FALSE(IsAllowed(read, "upper", "cup"));
  EXPECT_TRUE(IsAllowed(read, "base", "tray"));
  EXPECT_THAT(read.allowed_collisions.defaults, ElementsAre(std::pair("base", true)));
}

// The SRDF disables the pair, which MoveIt's matrix can only say with true.
TEST(PlanningSceneTest, ForbidsWhatARuleChecks) {
  const auto arm = collision::testing::Arm(
      collision::testing::ArmUrdf(),
      "<robot name=\"arm\"><disable_collisions link1=\"base\" link2=\"tip\"/>"
      "<disable_collisions link1=\"upper\" link2=\"tip\"/></robot>");
  const auto world =
      WorldWith({{collision::testing::PutArm("crane", arm), std::nullopt},
                 {AllowCollision{.pair = {{"crane", "tip"}, {"crane", "base"}}, .check = true},
                  std::nullopt}});
  auto scene = MakePlanningScene(*world, 0);
  ASSERT_TRUE(AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene).ok());
  const formats::SceneFile read = Read(*scene);
  EXPECT_FALSE(IsAllowed(read, "base", "tip"));
  EXPECT_TRUE(IsAllowed(read, "upper", "tip"));
  EXPECT_FALSE(IsAllowed(read, "base", "upper"));
}

TEST(PlanningSceneTest, SaysWhichRulesItCannotSay) {
  const auto in_a_while = collision::ExpiryAfter(std::chrono::hours(1));
  const auto world = WorldWith(
      {{collision::testing::PutArm("crane"), std::nullopt},
       {collision::testing::PutArm("other"), std::nullopt},
       {AllowCollision{.pair = {{"cup"}, {"tray"}}, .expires = in_a_while}, std::nullopt},
       {collision::SetPairMargin{.pair = {{"cup"}, {"*"}}, .margin_m = 0.1}, std::nullopt},
       {collision::SetPairMargin{.pair = {{"mug"}, {"*"}}, .margin_m = 0.1}, std::nullopt},
       Allow({{"other"}, {"cup"}}),
       Allow({{"other", "tip"}, {"cup"}})});
  auto scene = MakePlanningScene(*world, 0);
  ASSERT_TRUE(AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene).ok());
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("cup and tray: allowed for good")));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("* and cup, * and mug: the margin of the pair")));
  EXPECT_THAT(scene->warnings,
              Contains(HasSubstr("cup and other, cup and other:tip: the rule is left out")));
  EXPECT_THAT(scene->allowed.names, ElementsAre("base", "cup", "tip", "tray", "upper"));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("other: left out, a scene has one robot")));
}

TEST(PlanningSceneTest, SaysWhatTheRobotHoldsInTheFrameOfTheLink) {
  const auto world = WorldWith({{collision::testing::PutArm("crane"), std::nullopt}});
  PlanningScene scene;
  PlannedObject cup{.name = "cup", .X_WO = MakeTranslation(5, 0, 0), .shapes = {}};
  cup.shapes.push_back(ToPlannerShape({Pose::Identity(), Sphere{0.1}}));
  scene.objects = {cup, cup};
  scene.objects[0].attachment = {.robot = "crane",
                                 .link = "tip",
                                 .X_LO = MakeTranslation(0, 0, 0.1),
                                 .touch_links = {"fore"},
                                 .supported_by = "table"};
  scene.objects[1].name = "mug";
  scene.objects[1].attachment = {.robot = "other", .link = "tip", .touch_links = {}};
  PlanningScene objects_alone = scene;
  ASSERT_TRUE(AddRobotAndRules(*world, world->FindRobot("crane").get(), scene).ok());
  const formats::SceneFile read = Read(scene);
  ASSERT_EQ(read.robot_state.attached.size(), 1u);
  const formats::SceneAttachedObject& attached = read.robot_state.attached[0];
  EXPECT_EQ(attached.object.id, "cup");
  EXPECT_EQ(attached.link, "tip");
  EXPECT_TRUE(attached.pose_is_in_link);
  EXPECT_THAT(attached.object.shapes.at(0).pose.position_m, ElementsAre(0, 0, 0.1));
  EXPECT_THAT(attached.touch_links, ElementsAre("fore"));
  ASSERT_EQ(read.objects.size(), 1u);
  EXPECT_EQ(read.objects[0].id, "mug");
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("mug: stands free, it is attached to other")));
  EXPECT_THAT(scene.warnings, Contains(HasSubstr("cup: what supports it is left out")));
  RemoveAttached(objects_alone);
  EXPECT_TRUE(objects_alone.objects.empty());
  EXPECT_THAT(objects_alone.warnings,
              Contains(HasSubstr("cup: left out, it is attached to crane")));
}

Change PutBall(const std::string& name, collision::ObjectKind kind) {
  HybridModel ball;
  ball.shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}, .fit = {}});
  return {collision::PutObject{
              .name = name,
              .kind = kind,
              .geometry = collision::Prepare(std::make_shared<const HybridModel>(std::move(ball))),
              .supported_by = {}},
          std::nullopt};
}

TEST(PlanningSceneTest, SaysWhatIsUnseenSpace) {
  const auto world = WorldWith({PutBall("behind", collision::ObjectKind::kUnseen)});
  const auto scene = MakePlanningScene(*world, 0);
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_THAT(scene->warnings, ElementsAre(HasSubstr("behind: becomes an object like any other")));
}

TEST(PlanningSceneTest, HasSoManyAllowedNamesAndNoMore) {
  std::vector<Change> changes;
  for (std::size_t i = 0; i < kMaxMatrixNames - 1; ++i) {
    changes.push_back(Allow({{"hub"}, {"thing" + std::to_string(i)}}));
  }
  std::vector<std::string> warnings;
  const auto largest = MakeAllowedCollisionMatrix(*WorldWith(changes), nullptr, warnings);
  ASSERT_TRUE(largest.ok()) << largest.status();
  EXPECT_EQ(largest->names.size(), kMaxMatrixNames);
  changes.push_back(Allow({{"hub"}, {"one"}}));
  const auto more = MakeAllowedCollisionMatrix(*WorldWith(changes), nullptr, warnings);
  EXPECT_EQ(more.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(DetailsOf(more.status()).reason, "EXPORT_TOO_LARGE");
  EXPECT_THAT(std::string(more.status().message()),
              AllOf(HasSubstr("2049 names"), HasSubstr("at most 2048")));
}

// The caller may cancel at any time; the work then ends with the callback's status.
TEST(PlanningSceneTest, EndsWhereverItIsToldTo) {
  const auto world = WorldWith({{collision::testing::PutArm("crane"), std::nullopt},
                                PutBall("cup", collision::ObjectKind::kUser),
                                Allow({{"crane", "tip"}, {"*"}}),
                                Allow({{"cup"}, {"tray"}})});
  int check_count = 0;
  const auto make = [&](int times) -> absl::Status {
    check_count = 0;
    const CancellationCheck check_cancelled = [&] {
      return ++check_count > times ? absl::CancelledError("enough") : absl::OkStatus();
    };
    auto scene = MakePlanningScene(*world, 0, check_cancelled);
    if (!scene.ok()) return scene.status();
    const auto added =
        AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene, check_cancelled);
    if (!added.ok()) return added;
    const auto text = FormatSceneText(*scene, check_cancelled);
    return text.ok() ? FormatSceneYaml(*scene, check_cancelled).status() : text.status();
  };
  ASSERT_TRUE(make(1'000).ok());
  const int all = check_count;
  EXPECT_EQ(all, 3 * 1 + 7 + 2 + 1 + 5);  // three for the cup, links, rules, defaults, rows
  for (int times = 0; times < all; ++times) {
    EXPECT_TRUE(absl::IsCancelled(make(times))) << times;
    EXPECT_EQ(check_count, times + 1);
  }
}

TEST(PlanningSceneTest, WritesNumbersAndNamesThatEveryReaderTakesForSuch) {
  EXPECT_EQ(NumberText(1e-5), "1.0e-05");
  EXPECT_EQ(NumberText(-0.0), "0");
  EXPECT_EQ(NumberText(0.1), "0.1");
  EXPECT_EQ(NumberText(1.5e-300), "1.5e-300");
  EXPECT_EQ(std::stod(NumberText(1.0 / 3)), 1.0 / 3);
  EXPECT_EQ(Quoted("true"), "\"true\"");
  EXPECT_EQ(Quoted("a\"b\\\n"), "\"a\\\"b\\\\\\x0a\"");
}

}  // namespace
}  // namespace cwm::server
