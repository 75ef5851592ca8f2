#include "server/wire/robots.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "server/wire/robot_header.h"
#include "server/wire/watch_events.h"
#include "tests/collision/world/test_arm.h"
#include "tests/server/wire/wire_test_values.h"

namespace cwm::server {
namespace {

using collision::testing::Arm;
using collision::testing::ArmUrdf;
using collision::testing::PutArm;
using ::testing::ElementsAre;

collision::WorldRobot WorldArm() {
  const collision::PutRobot put = PutArm("left");
  return {.name = put.name,
          .robot = put.robot,
          .X_WB = MakeTranslation(1, 2, 3),
          .state = put.state,
          .create_revision = {3},
          .state_revision = {5},
          .X_WL = {},
          .body = {}};
}

TEST(WireRobot, TellsLinksVariablesGroupsAndState) {
  const v1::Robot robot = RobotToProto(WorldArm());
  EXPECT_EQ(robot.name(), "left");
  EXPECT_EQ(robot.uid(), "left@3");
  EXPECT_EQ(robot.x_world_base().tz_m(), 3);
  EXPECT_EQ(robot.create_revision(), 3);
  EXPECT_EQ(robot.state_revision(), 5);
  ASSERT_EQ(robot.links_size(), 7);
  EXPECT_EQ(robot.links(0).name(), "base");
  EXPECT_EQ(robot.links(0).joint_kind(), v1::JOINT_KIND_UNSPECIFIED);
  EXPECT_EQ(robot.links(0).collision_count(), 1);
  ASSERT_EQ(robot.variables_size(), 10);
  EXPECT_EQ(robot.state_size(), 10);
  EXPECT_EQ(robot.variables(0).name(), "elbow");
  EXPECT_EQ(robot.variables(0).joint_kind(), v1::JOINT_KIND_REVOLUTE);
  EXPECT_EQ(robot.variables(0).lower(), -1);
  EXPECT_EQ(robot.variables(0).upper(), 1);
  const v1::RobotVariable& last = robot.variables(9);
  EXPECT_EQ(last.joint(), "float");
  EXPECT_FALSE(last.has_lower()) << "unlimited is absent, never a number";
  ASSERT_EQ(robot.groups_size(), 1);
  EXPECT_THAT(robot.groups(0).joints(), ElementsAre("elbow", "slide"));
  ASSERT_EQ(robot.groups(0).states_size(), 1);
  EXPECT_EQ(robot.groups(0).states(0).values(0).variable(), "elbow");
  EXPECT_EQ(robot.groups(0).states(0).values(0).value(), 0.5);
  EXPECT_EQ(robot.self_pair_count(), static_cast<std::int64_t>(Arm()->model->self_pairs.size()));
  int shaped = 0, unchecked = 0;
  for (const v1::RobotLink& link : robot.links()) {
    shaped += link.collision_count() > 0 ? 1 : 0;
    unchecked += link.unchecked_links_size();
  }
  EXPECT_EQ(robot.self_pair_count() + unchecked, shaped * (shaped - 1) / 2);
  for (const v1::RobotLink& link : robot.links()) {
    EXPECT_EQ(link.follows(), link.name() == "right" ? "grip" : "") << link.name();
    EXPECT_EQ(link.collision_count() == 2, link.name() == "tip");
  }
}

TEST(WireRobot, CountsTheSpheresOfItsLinks) {
  collision::WorldRobot arm = WorldArm();
  EXPECT_EQ(RobotToProto(arm).links(0).sphere_count(), 0);
  collision::SphereModel spheres;
  spheres.links.resize(7);
  spheres.links[0] = {{}, {}};
  arm.robot = Arm(ArmUrdf(), collision::testing::ArmSrdf(), spheres);
  EXPECT_EQ(RobotToProto(arm).links(0).sphere_count(), 2);
  EXPECT_EQ(RobotToProto(arm).links(1).sphere_count(), 0);
}

class WireRobotState : public ::testing::Test {
 protected:
  WireRobotState() {
    set_.set_name("left");
    v1::VariableValue* value = set_.mutable_joints()->add_values();
    value->set_variable("elbow");
    value->set_value(0.25);
  }
  std::string Fault() {
    const FieldPath root;
    return FieldAtFault(SetRobotStateFromProto(set_, root.Field("robot_state")).status());
  }
  v1::SetRobotState set_;
};

TEST_F(WireRobotState, LeavesOutWhatIsNotGiven) {
  const auto set = SetRobotStateFromProto(set_, FieldPath());
  ASSERT_TRUE(set.ok()) << set.status();
  EXPECT_FALSE(set->X_WB.has_value());
  EXPECT_FALSE(set->joints.named.has_value());
  ASSERT_EQ(set->joints.values.size(), 1u);
  EXPECT_EQ(set->joints.values[0].variable, "elbow");
  EXPECT_EQ(set->joints.values[0].value, 0.25);
}

TEST_F(WireRobotState, NamesWhatIsMalformed) {
  EXPECT_EQ(Fault(), "");
  set_.set_name("");
  EXPECT_EQ(Fault(), "robot_state.name");
  set_.set_name("left");
  set_.mutable_x_world_base()->set_qw(2);
  EXPECT_EQ(Fault().substr(0, 24), "robot_state.x_world_base");
  set_.mutable_x_world_base()->set_qw(1);
  set_.mutable_joints()->set_group("reach");
  EXPECT_EQ(Fault(), "robot_state.joints.named_state");
  set_.mutable_joints()->set_named_state("ready");
  EXPECT_EQ(Fault(), "");
  set_.mutable_joints()->clear_group();
  EXPECT_EQ(Fault(), "robot_state.joints.group");
  set_.clear_joints();
  set_.mutable_joints()->add_values()->set_value(std::nan(""));
  EXPECT_EQ(Fault(), "robot_state.joints.values[0].value");
  set_.mutable_joints()->mutable_values(0)->set_value(0);
  set_.mutable_joints()->mutable_values(0)->set_variable(std::string(1'025, 'a'));
  EXPECT_EQ(Fault(), "robot_state.joints.values[0].variable");
}

TEST(WireRobotHeader, TakesTextsAndFilesAlike) {
  v1::LoadRobotHeader header;
  const FieldPath root;
  EXPECT_EQ(FieldAtFault(RobotPlanFromProto(header, root.Field("header")).status()), "header.urdf");
  header.set_urdf_file("r.urdf");
  header.set_srdf("<robot/>");
  const auto plan = RobotPlanFromProto(header, root.Field("header"));
  ASSERT_TRUE(plan.ok()) << plan.status();
  const auto files = MakeRobotFiles(*plan, {{"r.urdf", "text"}, {"a.stl", "mesh"}}, root);
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ(files->urdf, "text");
  EXPECT_EQ(files->srdf, "<robot/>");
  EXPECT_FALSE(files->spheres.has_value());
  EXPECT_EQ(files->meshes.at("a.stl"), "mesh");
  EXPECT_EQ(FieldAtFault(MakeRobotFiles(*plan, {}, root.Field("header")).status()),
            "header.urdf_file");
}

TEST(WireRobotHeader, GivesTheRobotItsNameAndItsState) {
  RobotPlan plan;
  const FieldPath root;
  const FieldPath path = root.Field("header");
  EXPECT_EQ(MakePutRobot(plan, Arm(), path)->name, "arm");
  EXPECT_EQ(FieldAtFault(MakePutRobot(plan, Arm(ArmUrdf("my arm")), path).status()), "header.name");
  plan.name = "left";
  EXPECT_EQ(MakePutRobot(plan, Arm(ArmUrdf("my arm")), path)->name, "left");
  plan.initial_state.named = {"reach", "ready"};
  EXPECT_EQ(MakePutRobot(plan, Arm(), path)->state[0], 0.5);
  plan.initial_state.named->state = "home";
  EXPECT_EQ(FieldAtFault(MakePutRobot(plan, Arm(), path).status()),
            "header.initial_state.named_state");
}

class WireRobotEvents : public ::testing::Test {
 protected:
  v1::RobotEvent EventOf(const collision::WorldRobotPtr& before,
                         const collision::WorldRobotPtr& after) {
    WatchStep step;
    step.kind = WatchStep::Kind::kEvents;
    step.revision = {6};
    step.robot_deltas.push_back({before, after});
    std::size_t next = 0;
    const auto message = EventsPiece(step, context_, &next);
    EXPECT_EQ(next, 1u);
    EXPECT_FALSE(message.events().more());
    EXPECT_EQ(message.events().robot_events_size(), 1);
    return message.events().robot_events(0);
  }

  World world_{"w", "uid", Retention{}};
  GeometryStore store_{std::int64_t{1} << 20};
  WatchContext context_{world_, View::kShapes, store_};
};

TEST_F(WireRobotEvents, AMotionIsSmallAndAnotherRobotIsAPut) {
  const auto before = collision::Place(WorldArm());
  collision::WorldRobot moved = *before;
  moved.state[0] = 0.75;
  moved.state_revision = {6};
  const auto after = collision::Place(moved);
  const v1::RobotEvent state = EventOf(before, after);
  EXPECT_EQ(state.state().name(), "left");
  EXPECT_EQ(state.state().state(0), 0.75);
  EXPECT_EQ(state.state().x_world_base().ty_m(), 2);
  EXPECT_EQ(state.state().state_revision(), 6);
  EXPECT_EQ(EventOf(before, nullptr).remove(), "left");
  EXPECT_EQ(EventOf(nullptr, after).put().uid(), "left@3");
}

TEST_F(WireRobotEvents, TheInitialStateTellsRobotsAfterAllObjects) {
  std::vector<collision::WorldObjectPtr> objects;
  const auto geometry = [] {
    auto model = std::make_shared<HybridModel>();
    model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}});
    return collision::Prepare(std::move(model));
  }();
  // More than one message can hold: each object has about a hundred bytes.
  for (int i = 100'000; i < 110'000; ++i) {
    collision::WorldObject object;
    object.name = "object_" + std::to_string(i);
    object.geometry = geometry;
    objects.push_back(collision::Place(std::move(object)));
  }
  const collision::WorldSnapshot snapshot({6}, objects, {collision::Place(WorldArm())});
  std::size_t next = 0;
  int messages = 0, robots = 0;
  for (bool done = false; !done; ++messages) {
    const auto message = InitialStatePiece(snapshot, context_, &next);
    done = message.initial_state().initial_state_done();
    robots += message.initial_state().robots_size();
    EXPECT_EQ(message.initial_state().robots_size(), done ? 1 : 0);
  }
  EXPECT_GT(messages, 1);
  EXPECT_EQ(robots, 1);
  EXPECT_EQ(next, 10'001u);
}

}  // namespace
}  // namespace cwm::server
