// Attached objects under changes of objects and robots.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/robot/kinematics.h"
#include "collision/world/world_snapshot.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using testing::Arm;
using testing::ArmUrdf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::MakeChange;
using testing::PutArm;
using testing::SetElbow;
using SnapshotPtr = std::shared_ptr<const WorldSnapshot>;

PutObject Put(const std::string& name, const Shape& shape, const Pose& X_WO) {
  auto model = std::make_shared<HybridModel>();
  model->shapes.push_back({.X_OS = Pose::Identity(), .shape = shape});
  PutObject put;
  put.name = name;
  put.geometry = Prepare(std::move(model));
  put.X_WO = X_WO;
  return put;
}

AttachObject ToTip(const std::string& name) {
  return {.name = name, .robot = "arm", .link = "tip"};
}

class Attachments : public ::testing::Test {
 protected:
  void SetUp() override {
    Do({MakeChange(PutArm("arm")),
        MakeChange(Put("cup", Sphere{0.05}, MakeTranslation(0.3, 0.2, 0.1)))});
  }
  void Do(const std::vector<Change>& changes) {
    auto next = Apply(world, changes);
    ASSERT_TRUE(next.ok()) << next.status();
    world = *std::move(next);
  }
  absl::Status Refusal(decltype(Change::what) what) {
    const Change change = MakeChange(std::move(what));
    const auto next = Apply(world, {&change, 1});
    EXPECT_FALSE(next.ok());
    return next.status();
  }
  std::string FieldAtFault(decltype(Change::what) what) {
    const auto fault = FaultOf(Refusal(std::move(what)));
    return fault.has_value() ? fault->field : "no fault";
  }
  // The link's pose from the kinematics alone.
  Pose LinkPose(const std::string& link) const {
    const WorldRobotPtr arm = world->FindRobot("arm");
    std::vector<Pose> X_WL(arm->model().links.size());
    LinkPoses(arm->model(), arm->X_WB, arm->state, X_WL);
    return X_WL[static_cast<std::size_t>(*arm->model().FindLink(link))];
  }
  double OffLink_m(const Pose& X_LO) const {
    return (world->Find("cup")->X_WO.matrix() - (LinkPose("tip") * X_LO).matrix()).norm();
  }

  SnapshotPtr world = std::make_shared<const WorldSnapshot>();
};

TEST_F(Attachments, WithoutAPoseStayWhereTheyAre) {
  const Pose X_WO = world->Find("cup")->X_WO;
  Do({MakeChange(ToTip("cup"))});
  const WorldObjectPtr cup = world->Find("cup");
  ASSERT_NE(cup->attachment, nullptr);
  EXPECT_EQ(cup->attachment->robot, "arm");
  EXPECT_LT((cup->X_WO.matrix() - X_WO.matrix()).norm(), 1e-15);
  EXPECT_EQ(cup->pose_revision, world->revision());
  ASSERT_EQ(world->attached().size(), 1u);
  EXPECT_EQ(world->attached()[0], cup);
}

TEST_F(Attachments, MoveWithTheRobotInItsRevision) {
  const Pose X_LO = MakeTranslation(0, 0.1, 0.2);
  AttachObject attach = ToTip("cup");
  attach.X_LO = X_LO;
  Do({MakeChange(attach)});
  EXPECT_LT(OffLink_m(X_LO), 1e-15);
  const SnapshotPtr before = world;
  Do({MakeChange(SetElbow("arm", 0.7))});
  EXPECT_EQ(world->revision().value, before->revision().value + 1);
  EXPECT_LT(OffLink_m(X_LO), 1e-15);
  EXPECT_EQ(world->Find("cup")->pose_revision, world->revision());
  EXPECT_EQ(Difference(*before, *world).size(), 1u);
  SetRobotState base{.name = "arm", .X_WB = MakeTranslation(1, 2, 3), .joints = {}};
  Do({MakeChange(base)});
  EXPECT_LT(OffLink_m(X_LO), 1e-15);
  EXPECT_GT(world->Find("cup")->X_WO.translation().norm(), 3);
  EXPECT_TRUE(world->Find("cup")->bounds_W.contains(world->Find("cup")->X_WO.translation()));
}

TEST_F(Attachments, SaidAgainHaveNoEffect) {
  AttachObject attach = ToTip("cup");
  attach.touch_links = {"upper", "base", "upper"};
  Do({MakeChange(attach), MakeChange(SetElbow("arm", 0.3))});
  const SnapshotPtr before = world;
  EXPECT_THAT(world->Find("cup")->attachment->touch_links, ElementsAre("base", "upper"));
  attach.touch_links = {"base", "upper"};
  Do({MakeChange(attach)});
  EXPECT_EQ(world, before);
  Do({MakeChange(SetElbow("arm", 0.9)), MakeChange(SetElbow("arm", 0.3))});
  EXPECT_EQ(world, before) << "there and back";
  Do({MakeChange(SetElbow("arm", 0.3))});
  EXPECT_EQ(world, before);
  attach.X_LO = before->Find("cup")->attachment->X_LO;
  Do({MakeChange(attach)});
  EXPECT_EQ(world, before);
}

TEST_F(Attachments, EndWhereTheyAre) {
  Do({MakeChange(ToTip("cup")), MakeChange(SetElbow("arm", 0.4))});
  const Pose X_WO = world->Find("cup")->X_WO;
  Do({MakeChange(DetachObject{"cup"})});
  EXPECT_EQ(world->Find("cup")->attachment, nullptr);
  EXPECT_EQ(world->Find("cup")->X_WO.matrix(), X_WO.matrix());
  EXPECT_TRUE(world->attached().empty());
  const SnapshotPtr before = world;
  Do({MakeChange(DetachObject{"cup"})});
  EXPECT_EQ(world, before) << "it stands free already";
  Do({MakeChange(SetElbow("arm", 0))});
  EXPECT_EQ(world->Find("cup")->X_WO.matrix(), X_WO.matrix());
}

TEST_F(Attachments, EndWithAMoveAPutAndARemoval) {
  for (const auto& what : std::vector<decltype(Change::what)>{
           MoveObject{"cup", MakeTranslation(0, 1, 0)},
           Put("cup", Sphere{0.05}, world->Find("cup")->X_WO), RemoveObject{"cup"}}) {
    Do({MakeChange(ToTip("cup")), MakeChange(what)});
    EXPECT_TRUE(world->attached().empty());
    Do({MakeChange(Put("cup", Sphere{0.05}, MakeTranslation(0.3, 0.2, 0.1)))});
    EXPECT_EQ(world->Find("cup")->attachment, nullptr);
  }
  Do({MakeChange(ToTip("cup"))});
  Do({MakeChange(MoveObject{"cup", world->Find("cup")->X_WO})});
  EXPECT_EQ(world->Find("cup")->attachment, nullptr) << "to the very pose that it has";
}

TEST_F(Attachments, StayWithALinkOfAnotherModelOrEnd) {
  Do({MakeChange(ToTip("cup"))});
  const Pose X_LO = world->Find("cup")->attachment->X_LO;
  PutRobot moved = PutArm("arm", Arm(ArmUrdf("arm", "0.2")));
  moved.X_WB = MakeTranslation(0, 0, 1);
  Do({MakeChange(moved)});
  ASSERT_NE(world->Find("cup")->attachment, nullptr);
  EXPECT_LT(OffLink_m(X_LO), 1e-15);
  const Pose X_WO = world->Find("cup")->X_WO;
  const std::string other = "<robot name=\"arm\"><link name=\"base\"/></robot>";
  Do({MakeChange(PutArm("arm", Arm(other, "<robot name=\"arm\"/>")))});
  EXPECT_EQ(world->Find("cup")->attachment, nullptr);
  EXPECT_EQ(world->Find("cup")->X_WO.matrix(), X_WO.matrix());
}

TEST_F(Attachments, EndWithTheRobot) {
  Do({MakeChange(ToTip("cup"))});
  const Pose X_WO = world->Find("cup")->X_WO;
  Do({MakeChange(RemoveRobot{"arm"})});
  EXPECT_EQ(world->Find("cup")->attachment, nullptr);
  EXPECT_EQ(world->Find("cup")->X_WO.matrix(), X_WO.matrix());
  EXPECT_TRUE(world->attached().empty());
}

TEST_F(Attachments, AreOfWhatTheListSaysSoFar) {
  Do({MakeChange(SetElbow("arm", 0.5)), MakeChange(ToTip("cup")), MakeChange(SetElbow("arm", 0)),
      MakeChange(DetachObject{"cup"}), MakeChange(SetElbow("arm", 1))});
  // The object moved with the arm from 0.5 to 0, and not after it was detached.
  const Pose now = world->Find("cup")->X_WO;
  EXPECT_GT((now.translation() - Vector3(0.3, 0.2, 0.1)).norm(), 0.1);
  EXPECT_NEAR(now.translation().norm(), Vector3(0.3, 0.2, 0.1).norm(), 1e-12);
}

TEST_F(Attachments, RefuseWhatIsNotThere) {
  EXPECT_EQ(Refusal(ToTip("ghost")).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(Refusal(DetachObject{"ghost"}).code(), absl::StatusCode::kNotFound);
  AttachObject attach = ToTip("cup");
  attach.robot = "nobody";
  EXPECT_EQ(Refusal(attach).code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(FieldAtFault(attach), "robot");
  attach.robot = "arm";
  attach.link = "tail";
  EXPECT_EQ(FieldAtFault(attach), "link");
  EXPECT_THAT(std::string(Refusal(attach).message()),
              HasSubstr("'tail' must be a link of robot 'arm'"));
  attach.link = "tip";
  attach.touch_links = {"base", "tail"};
  EXPECT_EQ(FieldAtFault(attach), "touch_links[1]");
  attach.touch_links.clear();
  attach.X_LO = MakeTranslation(1e9, 0, 0);
  EXPECT_EQ(FieldAtFault(attach), "x_link_object");
  Do({MakeChange(Put("floor", HalfSpace{}, Pose::Identity()))});
  EXPECT_EQ(FieldAtFault(ToTip("floor")), "name");
  EXPECT_EQ(world->Find("cup")->attachment, nullptr);
}

TEST_F(Attachments, AreRefusedAtAnotherRevisionOfTheObject) {
  Change attach = MakeChange(ToTip("cup"));
  attach.expected_object_revision = Revision{0};
  EXPECT_EQ(Apply(world, {&attach, 1}).status().code(), absl::StatusCode::kAborted);
  attach.expected_object_revision = world->Find("cup")->latest_revision();
  EXPECT_TRUE(Apply(world, {&attach, 1}).ok());
}

TEST_F(Attachments, AreOneListThatIsSharedWhileNoneDiffers) {
  Do({MakeChange(Put("a", Sphere{0.1}, Pose::Identity())), MakeChange(ToTip("cup")),
      MakeChange(ToTip("a"))});
  const SnapshotPtr before = world;
  ASSERT_EQ(world->attached().size(), 2u);
  EXPECT_EQ(world->attached()[0]->name, "a");
  Do({MakeChange(Put("b", Sphere{0.1}, Pose::Identity()))});
  EXPECT_EQ(&world->attached(), &before->attached());
}

TEST_F(Attachments, RobotsAreObstaclesWhereTheirStatePutsThem) {
  Do({MakeChange(SetElbow("arm", 1))});
  const WorldRobotPtr arm = world->FindRobot("arm");
  ASSERT_EQ(arm->body.parts_W.size(), 4u);
  const Pose X_WL = LinkPose("upper");
  const Vector3 ball = X_WL * Vector3(0, 0, 0.2);
  EXPECT_LT((arm->body.parts_W[1].X_WP.translation() - ball).norm(), 1e-15);
  std::vector<std::string> met;
  const auto note = [&](const Obstacle& obstacle) { met.push_back(obstacle.name); };
  world->bounds().ForEachWithin({ball, ball}, 0, note);
  EXPECT_THAT(met, ElementsAre("arm"));
  EXPECT_EQ(&world->ObstacleAt(world->IndexOf(arm->body)), &arm->body);
  EXPECT_EQ(world->IndexOf(arm->body), 1u) << "objects come first";
  EXPECT_EQ(world->RankByName(arm->body), 0u);
  EXPECT_EQ(world->RankByName(*world->Find("cup")), 1u);
  Do({MakeChange(RemoveRobot{"arm"})});
  met.clear();
  world->bounds().ForEachWithin({ball, ball}, 0, note);
  EXPECT_TRUE(met.empty());
}

}  // namespace
}  // namespace cwm::collision
