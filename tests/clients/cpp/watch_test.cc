// The watch of the C++ client: what happens to a world, across a restart of its server.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>
#include <vector>

#include "tests/clients/cpp/running_server.h"
#include "tests/e2e/two_link_arm.h"

namespace cwm::testing {
namespace {

using ::testing::HasSubstr;

class Watches : public ClientTest {
 protected:
  World world_ = Connect();
};

// The next event of that kind; bookmarks may come at any time.
template <class Kind>
Kind NextOf(Watcher& watch) {
  while (auto event = watch.Next()) {
    if (auto* wanted = std::get_if<Kind>(&*event)) return std::move(*wanted);
    EXPECT_TRUE(std::holds_alternative<Bookmark>(*event)) << "another event than the wanted one";
  }
  ADD_FAILURE() << "the watch ended";
  return {};
}

TEST_F(Watches, TellWhatThereIsAndWhatHappens) {
  world_.Put("ball", Sphere{0.1});
  Watcher watch = world_.Watch();
  const Snapshot snapshot = NextOf<Snapshot>(watch);
  EXPECT_EQ(snapshot.revision, 1);
  EXPECT_EQ(snapshot.anew, "");
  ASSERT_EQ(snapshot.objects.size(), 1U);
  EXPECT_EQ(std::get<Sphere>(snapshot.objects[0].parts[0].shape).radius_m, 0.1);

  world_.Apply(
      {Move{.name = "ball", .X_WO = At(0, 0, 1)}, Put{.name = "box", .body = Box{1, 1, 1}}});
  const Changes changes = NextOf<Changes>(watch);
  EXPECT_EQ(changes.revision, 2);
  ASSERT_EQ(changes.events.size(), 2U);
  EXPECT_TRUE(std::get<ObjectMoved>(changes.events[0]).X_WO.isApprox(At(0, 0, 1)));
  EXPECT_EQ(std::get<ObjectPut>(changes.events[1]).object.name, "box");

  world_.Remove("box");
  EXPECT_EQ(std::get<ObjectRemoved>(NextOf<Changes>(watch).events.at(0)).name, "box");
  world_.LoadRobot({.urdf = kTwoLinkArm});
  EXPECT_EQ(std::get<RobotPut>(NextOf<Changes>(watch).events.at(0)).robot.name, "arm");
  world_.SetRobotState("arm", {.values = {{"elbow", 1}}});
  EXPECT_EQ(std::get<RobotMoved>(NextOf<Changes>(watch).events.at(0)).state, Eigen::Vector2d(0, 1));
  world_.Allow("arm", "ball");
  EXPECT_TRUE(std::get<RuleSet>(NextOf<Changes>(watch).events.at(0)).rule.allowed);
  world_.DeleteRobot("arm");
  EXPECT_EQ(std::get<RobotRemoved>(NextOf<Changes>(watch).events.at(0)).name, "arm");
}

TEST_F(Watches, ResumeAfterARevision) {
  world_.Put("ball", Sphere{0.1});
  world_.Put("box", Box{1, 1, 1});
  Watcher watch = world_.Watch({.from_revision = 1, .world_uid = world_.uid()});
  const Changes changes = NextOf<Changes>(watch);
  EXPECT_EQ(changes.revision, 2);
  EXPECT_EQ(std::get<ObjectPut>(changes.events.at(0)).object.name, "box");
}

TEST_F(Watches, GoOnAfterARestartOfTheServer) {
  RunningServer other;
  const World world = cwm::Connect({.address = other.address(), .world = "restarted"});
  world.Put("ball", Sphere{0.1});
  Watcher watch = world.Watch();
  EXPECT_EQ(NextOf<Snapshot>(watch).objects.size(), 1U);
  other.Stop();
  other.Start();
  // The server has lost its memory: the watch waits until somebody makes the world again.
  world.Put("cube", Box{1, 1, 1});
  const Snapshot again = NextOf<Snapshot>(watch);
  EXPECT_THAT(again.anew, HasSubstr("replaced"));
  ASSERT_EQ(again.objects.size(), 1U);
  EXPECT_EQ(again.objects[0].name, "cube");
  world.Remove("cube");
  EXPECT_EQ(NextOf<Changes>(watch).events.size(), 1U);
}

TEST_F(Watches, EndWhenTheyAreClosedOrTheWorldIsDeleted) {
  world_.Put("ball", Sphere{0.1});
  Watcher closed = world_.Watch();
  NextOf<Snapshot>(closed);
  std::thread closing([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    closed.Close();
  });
  while (closed.Next()) {
  }
  closing.join();
  EXPECT_FALSE(closed.Next().has_value());

  Watcher deleted = world_.Watch();
  NextOf<Snapshot>(deleted);
  world_.server().DeleteWorld(world_.name());
  EXPECT_EQ(ErrorOf([&] {
              while (deleted.Next()) {
              }
            }).code(),
            ErrorCode::kNotFound);
}

TEST_F(Watches, GiveUpOnAServerThatStaysAway) {
  RunningServer other;
  const World world = cwm::Connect({.address = other.address(), .world = "gone"});
  world.Put("ball", Sphere{0.1});
  Watcher watch = world.Watch({.give_up_after_s = 0.3});
  NextOf<Snapshot>(watch);
  other.Stop();
  EXPECT_EQ(ErrorOf([&] {
              while (watch.Next()) {
              }
            }).code(),
            ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace cwm::testing
