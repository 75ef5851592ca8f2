// A scene is updated, not piled up: one moved object costs one object's update.
#include <map>
#include <set>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

class SceneUpdate : public ServerTest {
 protected:
  json Ingest(const std::string& cloud, const std::string& name) {
    return CwmJson(
        {"ingest", cloud, "--x-world-sensor", PoseArgument(Truth(name).at("x_world_sensor"))});
  }

  std::map<std::string, json> Objects() {
    std::map<std::string, json> by_name;
    const json objects = CwmJson({"objects"}).at("objects");
    for (const json& object : objects) by_name[object.at("name")] = object;
    return by_name;
  }

  static std::size_t Unchanged(const std::map<std::string, json>& before,
                               const std::map<std::string, json>& after) {
    std::size_t count = 0;
    for (const auto& [name, object] : before) {
      const auto found = after.find(name);
      count += found != after.end() &&
               found->second.at("geometry_revision") == object.at("geometry_revision") &&
               found->second.at("pose_revision") == object.at("pose_revision");
    }
    return count;
  }
};

TEST_F(SceneUpdate, TheSameScanTwiceChangesNothing) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "1"});
  Ingest(cloud, "kitchen");
  const std::int64_t revision = RevisionOf("default");
  const auto before = Objects();
  const json again = Ingest(cloud, "kitchen");
  EXPECT_EQ(RevisionOf("default"), revision);
  EXPECT_EQ(Unchanged(before, Objects()), before.size());
  EXPECT_TRUE(again.at("changes").at("added").empty()) << again.at("changes");
}

TEST_F(SceneUpdate, FreshNoiseKeepsEveryObject) {
  const std::string first = Simulate("first", {"--scene", "kitchen", "--seed", "1"});
  const std::string second = Simulate("second", {"--scene", "kitchen", "--seed", "2"});
  Ingest(first, "first");
  const auto before = Objects();
  const json changes = Ingest(second, "second").at("changes");
  const auto after = Objects();
  for (const auto& [name, object] : before) {
    if (object.at("kind") != "OBJECT_KIND_OBJECT" && object.at("kind") != "OBJECT_KIND_SUPPORT")
      continue;
    EXPECT_TRUE(after.count(name)) << name << " was lost: " << changes;
  }
}

TEST_F(SceneUpdate, OneMovedObjectCostsOneObjectsUpdate) {
  const std::string first = Simulate("first", {"--scene", "kitchen", "--seed", "1"});
  Ingest(first, "first");
  const auto before = Objects();
  const json moved_one =
      Truth("first").at("objects").at(Truth("first").at("movable_index").get<int>());
  const std::string second =
      Simulate("second", {"--scene", "kitchen", "--seed", "1", "--move",
                          moved_one.at("name").get<std::string>() + "=0,-0.08,0"});
  const json changes = Ingest(second, "second").at("changes");
  const auto after = Objects();
  EXPECT_EQ(changes.at("moved").size() + changes.at("replaced").size(), 1U) << changes;
  EXPECT_TRUE(changes.at("removed").empty()) << changes;
  EXPECT_EQ(after.size(), before.size()) << changes;
  EXPECT_EQ(Unchanged(before, after), before.size() - 1) << changes;
}

TEST_F(SceneUpdate, ARemovedObjectGoesAndAnAddedOneComes) {
  const std::string full = Simulate("full", {"--scene", "kitchen", "--seed", "1"});
  const std::string name =
      Truth("full").at("objects").at(Truth("full").at("movable_index").get<int>()).at("name");
  const std::string without =
      Simulate("without", {"--scene", "kitchen", "--seed", "1", "--without", name});
  Ingest(full, "full");
  const auto before = Objects();
  const json gone = Ingest(without, "without").at("changes");
  EXPECT_EQ(gone.at("removed").size(), 1U) << gone;
  EXPECT_EQ(Objects().size(), before.size() - 1);
  const json back = Ingest(full, "full").at("changes");
  EXPECT_EQ(back.at("added").size(), 1U) << back;
  EXPECT_FALSE(before.count(back["added"][0])) << "a name is never given twice";
}

TEST_F(SceneUpdate, WhatUsersOwnIsNeverTouchedAndExplainsItsPoints) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "1"});
  const json truth = Truth("kitchen");
  const json mine = truth.at("objects").at(truth.at("movable_index").get<int>());
  // The user knows this object already, and puts a block around all of it.
  const json& centre = mine.at("centre");
  std::ostringstream at, size;
  at.precision(17), size.precision(17);
  at << centre.at("tx_m").get<double>() << "," << centre.at("ty_m").get<double>() << ","
     << centre.at("tz_m").get<double>();
  size << mine.at("size_m").at(0).get<double>() << "," << mine["size_m"].at(1).get<double>() << ","
       << mine["size_m"].at(2).get<double>();
  ASSERT_EQ(Cwm({"put", "mine", "--box", size.str(), "--at", at.str()}).exit_code, 0);
  const json before = CwmJson({"get", "mine"}).at("object");
  const json changes = Ingest(cloud, "kitchen").at("changes");
  EXPECT_EQ(CwmJson({"get", "mine"}).at("object"), before);
  for (const auto& [name, object] : Objects()) {
    if (object.at("kind") != "OBJECT_KIND_OBJECT") continue;
    const json& o = object.at("x_world_object");
    EXPECT_GT(std::hypot(o.at("tx_m").get<double>() - centre.at("tx_m").get<double>(),
                         o.at("ty_m").get<double>() - centre.at("ty_m").get<double>()),
              0.03)
        << name << " was made of points that the user's object explains";
  }
}

}  // namespace
}  // namespace cwm::testing
