// What a scene says beside its objects: the robot, who may touch whom.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "clients/formats/scene_file.h"
#include "server/export/moveit_scene.h"
#include "server/export/scene_numbers.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::server {
namespace {

using collision::AllowCollision;
using collision::Change;
using collision::NamedPair;
using collision::WorldSnapshot;
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
  const auto read = formats::ParseScene(FormatSceneYaml(scene), "exported");
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
  auto scene = SceneOf(*world, 0);
  ASSERT_TRUE(scene.ok());
  AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene);
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
  auto scene = SceneOf(*world, 0);
  AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene);
  const formats::SceneFile read = Read(*scene);
  EXPECT_THAT(read.allowed_collisions.names, ElementsAre("base", "cup", "tip", "tray", "upper"));
  EXPECT_TRUE(IsAllowed(read, "tip", "cup"));
  EXPECT_TRUE(IsAllowed(read, "cup", "tray"));
  EXPECT_FALSE(IsAllowed(read, "tip", "tray"));
  EXPECT_FALSE(IsAllowed(read, "upper", "cup"));
  EXPECT_TRUE(IsAllowed(read, "base", "tray"));
  EXPECT_THAT(read.allowed_collisions.defaults, ElementsAre(std::pair("base", true)));
}

TEST(PlanningSceneTest, SaysWhichRulesItCannotSay) {
  const auto in_a_while = std::chrono::system_clock::now() + std::chrono::hours(1);
  const auto world = WorldWith(
      {{collision::testing::PutArm("crane"), std::nullopt},
       {collision::testing::PutArm("other"), std::nullopt},
       {AllowCollision{.pair = {{"cup"}, {"tray"}}, .expires = in_a_while}, std::nullopt},
       {collision::SetPairMargin{.pair = {{"cup"}, {"*"}}, .margin_m = 0.1}, std::nullopt},
       Allow({{"other", "tip"}, {"cup"}})});
  auto scene = SceneOf(*world, 0);
  AddRobotAndRules(*world, world->FindRobot("crane").get(), *scene);
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("cup and tray: allowed for good")));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("* and cup: the margin of the pair")));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("other:tip: the rule is left out")));
  EXPECT_THAT(scene->warnings, Contains(HasSubstr("other: left out, a scene has one robot")));
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
