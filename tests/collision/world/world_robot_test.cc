#include "collision/world/world_robot.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "collision/world/model_equality.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using testing::ArmSrdf;
using testing::ArmUrdf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MakeChange;
using testing::PutArm;
using testing::SetElbow;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

PutObject Ball(const std::string& name) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(), .shape = Sphere{0.1}});
  PutObject put;
  put.name = name;
  put.geometry = Prepare(std::move(model));
  return put;
}

// A rail with limits beyond the range of coordinates.
constexpr char kRail[] =
    "<robot name=\"rail\"><link name=\"a\"/><link name=\"b\"/><joint name=\"j\" type=\"prismatic\">"
    "<parent link=\"a\"/><child link=\"b\"/><limit lower=\"-1e9\" upper=\"1e9\"/></joint></robot>";

class WorldRobots : public ::testing::Test {
 protected:
  void Do(const std::vector<Change>& changes) {
    auto next = Apply(world, changes);
    ASSERT_TRUE(next.ok()) << next.status();
    world = *std::move(next);
  }
  absl::Status Refusal(const std::vector<Change>& changes) {
    const auto next = Apply(world, changes);
    EXPECT_FALSE(next.ok());
    return next.status();
  }
  std::string FieldAtFault(decltype(Change::what) what) {
    const auto fault = FaultOf(Refusal({MakeChange(std::move(what))}));
    return fault.has_value() ? fault->field : "no fault";
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const WorldRobotPtr& robot : world->robots()) names.push_back(robot->name);
    return names;
  }

  SnapshotPtr world = std::make_shared<const WorldSnapshot>();
};

TEST(PrepareRobot, EndsWhenItIsStopped) {
  std::stop_source stop;
  EXPECT_NE(PrepareRobot(Arm()->model, std::nullopt, stop.get_token()), nullptr);
  stop.request_stop();
  EXPECT_EQ(PrepareRobot(Arm()->model, std::nullopt, stop.get_token()), nullptr);
}

TEST(PrepareRobot, MakesOnePartOfEachShapeInTheFrameOfItsLink) {
  const auto arm = Arm();
  const RobotModel& model = *arm->model;
  ASSERT_EQ(arm->geometry->parts.size(), 4u);
  ASSERT_EQ(arm->link_of_part.size(), 4u);
  EXPECT_TRUE(std::is_sorted(arm->link_of_part.begin(), arm->link_of_part.end()));
  std::vector<std::string> links;
  for (std::size_t i = 0; i < arm->link_of_part.size(); ++i) {
    const ModelLink& link = model.links[arm->link_of_part[i]];
    links.push_back(link.name);
    const double z = link.name == "tip" ? 0 : 0.2;
    EXPECT_EQ(arm->geometry->parts[i].X_OP.translation(), Vector3(0, 0, z)) << link.name;
  }
  EXPECT_THAT(links, ElementsAre("base", "upper", "tip", "tip"));
}

TEST_F(WorldRobots, AreOrderedByNameWhateverTheOrderOfPuts) {
  const auto arm = Arm();
  Do({MakeChange(PutArm("c", arm)), MakeChange(PutArm("a", arm))});
  Do({MakeChange(PutArm("b", arm))});
  EXPECT_THAT(Names(), ElementsAre("a", "b", "c"));
  EXPECT_EQ(world->FindRobot("b")->Uid(), "b@2");
  EXPECT_EQ(world->FindRobot("d"), nullptr);
  Do({MakeChange(RemoveRobot{"a"})});
  EXPECT_THAT(Names(), ElementsAre("b", "c"));
}

TEST_F(WorldRobots, PutAgainMakesNoRevisionThoughItWasReadAnew) {
  Do({MakeChange(PutArm("arm"))});
  const SnapshotPtr before = world;
  Do({MakeChange(PutArm("arm", Arm()))});
  EXPECT_EQ(world, before);
}

TEST_F(WorldRobots, OfAnotherModelUnderTheNameAreOthers) {
  Do({MakeChange(PutArm("arm"))});
  const SnapshotPtr before = world;
  Do({MakeChange(PutArm("arm", Arm(ArmUrdf("arm", "0.2"))))});
  EXPECT_EQ(world->revision(), Revision{2});
  const WorldRobotPtr other = world->FindRobot("arm");
  EXPECT_EQ(other->Uid(), "arm@2");
  EXPECT_EQ(other->create_revision, Revision{2});
  const auto deltas = RobotDifference(*before, *world);
  ASSERT_EQ(deltas.size(), 2u);
  EXPECT_EQ(deltas[0].before->Uid(), "arm@1");
  EXPECT_EQ(deltas[0].after, nullptr);
  EXPECT_EQ(deltas[1].before, nullptr);
  EXPECT_EQ(deltas[1].after, other);
}

TEST_F(WorldRobots, MoveWithoutNewGeometry) {
  Do({MakeChange(PutArm("arm"))});
  const WorldRobotPtr before = world->FindRobot("arm");
  SetRobotState set = SetElbow("arm", 0.25);
  set.X_WB = MakeTranslation(1, 2, 3);
  Do({MakeChange(set)});
  const WorldRobotPtr after = world->FindRobot("arm");
  EXPECT_EQ(after->robot, before->robot);
  EXPECT_EQ(after->Uid(), before->Uid());
  EXPECT_EQ(after->state[0], 0.25);
  EXPECT_EQ(after->X_WB.translation(), Vector3(1, 2, 3));
  EXPECT_EQ(after->create_revision, Revision{1});
  EXPECT_EQ(after->state_revision, Revision{2});
  EXPECT_EQ(before->state[0], 0) << "older snapshots answer as they did";
  // Sets only the state; the base stays.
  Do({MakeChange(SetElbow("arm", 0.5))});
  EXPECT_EQ(world->FindRobot("arm")->X_WB.translation(), Vector3(1, 2, 3));
}

TEST_F(WorldRobots, ThatEndAsTheyWereMakeNoRevision) {
  Do({MakeChange(PutArm("arm"))});
  const SnapshotPtr before = world;
  Do({MakeChange(SetElbow("arm", 0.5)), MakeChange(SetElbow("arm", 0))});
  Do({MakeChange(PutArm("brief")), MakeChange(RemoveRobot{"brief"})});
  EXPECT_EQ(world, before);
}

TEST_F(WorldRobots, ChangeWithObjectsOrNotAtAll) {
  Do({MakeChange(PutArm("arm")), MakeChange(Ball("ball"))});
  const SnapshotPtr before = world;
  EXPECT_EQ(Refusal({MakeChange(SetElbow("arm", 1)), MakeChange(RemoveObject{"ghost"})}).code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(Refusal({MakeChange(RemoveObject{"ball"}), MakeChange(RemoveRobot{"ghost"})}).code(),
            absl::StatusCode::kNotFound);
  EXPECT_EQ(world, before);
  Do({MakeChange(SetElbow("arm", 1)), MakeChange(RemoveObject{"ball"})});
  EXPECT_EQ(world->revision(), Revision{2});
  EXPECT_EQ(Difference(*before, *world).size(), 1u);
  EXPECT_EQ(RobotDifference(*before, *world).size(), 1u);
}

TEST_F(WorldRobots, AreSharedBySnapshotsBetweenWhichNoneDiffers) {
  Do({MakeChange(PutArm("arm"))});
  const SnapshotPtr before = world;
  Do({MakeChange(Ball("ball"))});
  EXPECT_EQ(&before->robots(), &world->robots());
  EXPECT_TRUE(RobotDifference(*before, *world).empty());
}

TEST_F(WorldRobots, AndObjectsDoNotShareNames) {
  Do({MakeChange(PutArm("arm")), MakeChange(Ball("ball"))});
  EXPECT_EQ(FieldAtFault(PutArm("ball")), "name");
  EXPECT_EQ(FieldAtFault(Ball("arm")), "name");
  EXPECT_THAT(std::string(Refusal({MakeChange(Ball("arm"))}).message()), HasSubstr("a robot"));
  EXPECT_THAT(std::string(Refusal({MakeChange(PutArm("ball"))}).message()), HasSubstr("an object"));
  // A name is free once an earlier change of the list has freed it.
  Do({MakeChange(RemoveObject{"ball"}), MakeChange(PutArm("ball")), MakeChange(RemoveRobot{"arm"}),
      MakeChange(Ball("arm"))});
  EXPECT_THAT(Names(), ElementsAre("ball"));
  EXPECT_NE(world->Find("arm"), nullptr);
}

TEST_F(WorldRobots, ThatNoWorldMayHoldAreRefusedWithTheirField) {
  PutRobot put = PutArm("arm");
  EXPECT_EQ(FieldAtFault(PutArm("a b")), "name");
  put.robot = nullptr;
  EXPECT_EQ(FieldAtFault(put), "robot");
  put = PutArm("arm");
  put.state.pop_back();
  EXPECT_EQ(FieldAtFault(put), "state");
  put = PutArm("arm");
  put.state[0] = std::nan("");
  EXPECT_EQ(FieldAtFault(put), "state");
  put = PutArm("arm");
  put.X_WB.translation().x() = INFINITY;
  EXPECT_EQ(FieldAtFault(put), "x_world_base");
  Do({MakeChange(PutArm("arm"))});
  EXPECT_EQ(FieldAtFault(SetElbow("arm", std::nan(""))), "joints.values[0].value");
  SetRobotState set = SetElbow("arm", 0);
  set.X_WB = put.X_WB;
  EXPECT_EQ(FieldAtFault(set), "x_world_base");
}

TEST_F(WorldRobots, AbortAListThatExpectedAnotherRevisionOfThem) {
  Do({MakeChange(PutArm("arm"))});
  Do({MakeChange(SetElbow("arm", 0.5))});
  Change late = MakeChange(SetElbow("arm", 1));
  late.expected_object_revision = Revision{1};
  EXPECT_EQ(Refusal({late}).code(), absl::StatusCode::kAborted);
  late.expected_object_revision = Revision{2};
  Do({late});
  EXPECT_EQ(world->FindRobot("arm")->state[0], 1);
  Change missing = MakeChange(RemoveRobot{"ghost"});
  missing.expected_object_revision = Revision{1};
  EXPECT_EQ(Refusal({missing}).code(), absl::StatusCode::kAborted);
}

TEST_F(WorldRobots, KeepTheirLinksWhereWorldsHaveRoom) {
  PutRobot put = PutArm("rail", Arm(kRail, "<robot name=\"rail\"/>"));
  put.state = {6e5};
  put.X_WB = MakeTranslation(5e5, 0, 0);
  EXPECT_EQ(FieldAtFault(put), "state");
  put.X_WB = Pose::Identity();
  Do({MakeChange(put)});
  const SetRobotState to_far{.name = "rail", .X_WB = MakeTranslation(5e5, 0, 0), .joints = {}};
  EXPECT_EQ(FieldAtFault(to_far), "x_world_base");
  EXPECT_THAT(std::string(Refusal({MakeChange(to_far)}).message()),
              HasSubstr("puts link \"b\" at (1.1e+06, 0, 0), must be within 1e+06 m"));
  Do({MakeChange(
      SetRobotState{.name = "rail", .X_WB = MakeTranslation(-5e5, 0, 0), .joints = {}})});
  Do({MakeChange(SetRobotState{
      .name = "rail", .X_WB = std::nullopt, .joints = {.named = {}, .values = {{"j", 1e6}}}})});
  EXPECT_EQ(
      FieldAtFault(SetRobotState{
          .name = "rail", .X_WB = std::nullopt, .joints = {.named = {}, .values = {{"j", -6e5}}}}),
      "joints");
}

TEST(SameRobot, TellsApartWhatAnyAnswerCould) {
  const auto arm = Arm();
  EXPECT_TRUE(SameRobot(*arm, *Arm()));
  const auto spheres = [&](double radius_m) {
    SphereModel model;
    model.links.resize(arm->model->links.size());
    model.links[0].push_back({.center_L = Vector3::Zero(), .radius_m = radius_m});
    return Arm(ArmUrdf(), ArmSrdf(), model);
  };
  EXPECT_TRUE(SameRobot(*spheres(0.1), *spheres(0.1)));
  EXPECT_FALSE(SameRobot(*spheres(0.1), *spheres(0.2)));
  EXPECT_FALSE(SameRobot(*arm, *spheres(0.1)));
  EXPECT_FALSE(SameRobot(*arm, *Arm(ArmUrdf("leg"))));
  EXPECT_FALSE(SameRobot(*arm, *Arm(ArmUrdf("arm", "0.11"))));
  EXPECT_FALSE(SameRobot(*arm, *Arm(ArmUrdf(), ArmSrdf("0.6"))));
  EXPECT_FALSE(SameRobot(*arm, *Arm(ArmUrdf(), "<robot name=\"arm\"/>")));
  const auto with = [](const std::string& from, const std::string& to) {
    std::string urdf = ArmUrdf();
    const std::size_t at = urdf.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return Arm(urdf.replace(at, from.size(), to));
  };
  EXPECT_FALSE(SameRobot(*arm, *with("upper=\"0.5\"", "upper=\"0.6\"")));
  EXPECT_FALSE(SameRobot(*arm, *with("xyz=\"0 0 0.2\"", "xyz=\"0 0 0.3\"")));
  EXPECT_FALSE(SameRobot(*arm, *with("multiplier=\"-1\"", "multiplier=\"-2\"")));
  EXPECT_FALSE(SameRobot(
      *arm, *with("type=\"fixed\"><parent", "type=\"fixed\"><origin xyz=\"1 0 0\"/><parent")));
}

// Links of robots that do not exist yet are not checked.
TEST_F(WorldRobots, HaveTheLinksThatRulesOfPairsName) {
  const auto allow = [](NamedThing a, NamedThing b, bool withdraw = false) {
    return AllowCollision{
        .pair = {std::move(a), std::move(b)}, .withdraw = withdraw, .expires = {}};
  };
  Do({MakeChange(allow({"arm", "gone"}, {"cup"})), MakeChange(PutArm("arm")),
      MakeChange(Ball("ball"))});
  EXPECT_EQ(world->pair_rules().size(), 1U) << "of a robot that was not there yet";
  Do({MakeChange(allow({"arm", "tip"}, {"ball"})), MakeChange(allow({"other", "tipp"}, {"*"}))});
  const auto rule = [&](decltype(Change::what) what) {
    const auto fault = FaultOf(Refusal({MakeChange(std::move(what))}));
    return fault.has_value() ? fault->field + " " + fault->rule : "";
  };
  EXPECT_EQ(rule(allow({"arm", "tipp"}, {"ball"})),
            "pair.a.link is 'tipp', must be a link of robot 'arm'");
  EXPECT_EQ(rule(SetPairMargin{.pair = {{"*"}, {"arm", "tipp"}}, .margin_m = 0.1}),
            "pair.b.link is 'tipp', must be a link of robot 'arm'");
  EXPECT_EQ(rule(allow({"ball", "tip"}, {"*"})),
            "pair.a.link is 'tip', must be empty: 'ball' is an object, which has no links");
  // A rule for a link that no longer exists can be withdrawn.
  const std::size_t before = world->pair_rules().size();
  Do({MakeChange(allow({"arm", "gone"}, {"cup"}, /*withdraw=*/true)),
      MakeChange(SetPairMargin{.pair = {{"arm", "gone"}, {"cup"}}, .margin_m = {}})});
  EXPECT_EQ(world->pair_rules().size(), before - 1);
}

}  // namespace
}  // namespace cwm::collision
