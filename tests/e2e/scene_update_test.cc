// A scene is updated, not accumulated: one moved object causes one object's update.
#include <cmath>
#include <map>
#include <set>

#include "tests/e2e/server_fixture.h"

namespace cwm::testing {
namespace {

using nlohmann::json;

// derived: the noise at the movable object's distance is 1.8 mm (from its fit); a pose estimated
// from thousands of points is off by less than three standard deviations of a point.
constexpr double kPoseTolerance_m = 0.0054;
// derived: an object's origin lies among its observed points, within half of its smallest side (the
// movable object's is 70 mm, half of it observed).
constexpr double kOriginFromCentre_m = 0.05;

double Difference_m(const json& a, const json& b, const char* axis) {
  return a.at(axis).get<double>() - b.at(axis).get<double>();
}

// True if the object is at `centre`, seen from above.
bool IsAt(const json& object, const json& centre) {
  const json& pose = object.at("x_world_object");
  return std::hypot(Difference_m(pose, centre, "tx_m"), Difference_m(pose, centre, "ty_m")) <
         kOriginFromCentre_m;
}

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

  // The objects on the counter of the scene `kitchen`: three boxes, two cans, a ball, a cup, a mug.
  static constexpr std::size_t kObjectCount = 8;

  static std::size_t OfKind(const std::map<std::string, json>& objects, const std::string& kind) {
    return static_cast<std::size_t>(
        std::count_if(objects.begin(), objects.end(),
                      [&](const auto& o) { return o.second.at("kind") == kind; }));
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
  EXPECT_GE(OfKind(before, "OBJECT_KIND_OBJECT"), kObjectCount);
  const json again = Ingest(cloud, "kitchen");
  EXPECT_EQ(RevisionOf("default"), revision);
  EXPECT_EQ(Unchanged(before, Objects()), before.size());
  EXPECT_TRUE(again.at("changes").at("added").empty()) << again.at("changes");
}

TEST_F(SceneUpdate, FreshNoiseKeepsEveryObject) {
  const std::string first = Simulate("first", {"--scene", "kitchen", "--seed", "1"});
  const std::string second = Simulate("second", {"--scene", "kitchen", "--seed", "2"});
  Ingest(first, "first");
  const std::int64_t revision = RevisionOf("default");
  const auto before = Objects();
  EXPECT_GE(OfKind(before, "OBJECT_KIND_OBJECT"), kObjectCount);
  const json changes = Ingest(second, "second").at("changes");
  const auto after = Objects();
  EXPECT_EQ(changes.at("kept").size(), before.size()) << changes;
  EXPECT_EQ(after.size(), before.size()) << changes;
  EXPECT_EQ(Unchanged(before, after), before.size()) << changes;
  EXPECT_EQ(RevisionOf("default"), revision) << "what is kept makes no revision";
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
  ASSERT_EQ(changes.at("moved").size(), 1U) << changes;
  const std::string name = changes["moved"][0];
  ASSERT_TRUE(before.count(name) && after.count(name));
  EXPECT_TRUE(IsAt(before.at(name), moved_one.at("centre"))) << before.at(name);
  const json& from = before.at(name).at("x_world_object");
  const json& to = after.at(name).at("x_world_object");
  EXPECT_NEAR(Difference_m(to, from, "tx_m"), 0, kPoseTolerance_m);
  EXPECT_NEAR(Difference_m(to, from, "ty_m"), -0.08, kPoseTolerance_m);
  EXPECT_NEAR(Difference_m(to, from, "tz_m"), 0, kPoseTolerance_m);
  EXPECT_EQ(after.at(name).at("geometry_revision"), before.at(name).at("geometry_revision"));
  for (const char* other : {"added", "replaced", "removed", "occluded"}) {
    EXPECT_TRUE(changes.at(other).empty()) << changes;
  }
  EXPECT_EQ(after.size(), before.size()) << changes;
  EXPECT_EQ(Unchanged(before, after), before.size() - 1) << changes;
}

TEST_F(SceneUpdate, ARemovedObjectGoesAndAnAddedOneComes) {
  const std::string full = Simulate("full", {"--scene", "kitchen", "--seed", "1"});
  const json object = Truth("full").at("objects").at(Truth("full").at("movable_index").get<int>());
  const std::string name = object.at("name");
  const std::string without =
      Simulate("without", {"--scene", "kitchen", "--seed", "1", "--without", name});
  Ingest(full, "full");
  const auto before = Objects();
  const json gone = Ingest(without, "without").at("changes");
  ASSERT_EQ(gone.at("removed").size(), 1U) << gone;
  ASSERT_TRUE(before.count(gone["removed"][0])) << gone;
  EXPECT_TRUE(IsAt(before.at(gone["removed"][0]), object.at("centre"))) << gone;
  EXPECT_EQ(Objects().size(), before.size() - 1);
  EXPECT_EQ(Unchanged(before, Objects()), before.size() - 1) << "the rest is not touched";
  const json back = Ingest(full, "full").at("changes");
  ASSERT_EQ(back.at("added").size(), 1U) << back;
  EXPECT_FALSE(before.count(back["added"][0])) << "a name is never given twice";
  const auto after = Objects();
  ASSERT_TRUE(after.count(back["added"][0])) << back;
  EXPECT_TRUE(IsAt(after.at(back["added"][0]), object.at("centre"))) << back;
  EXPECT_EQ(after.size(), before.size());
}

TEST_F(SceneUpdate, WhatUsersOwnIsNeverTouchedAndExplainsItsPoints) {
  const std::string cloud = Simulate("kitchen", {"--scene", "kitchen", "--seed", "1"});
  const json truth = Truth("kitchen");
  const json mine = truth.at("objects").at(truth.at("movable_index").get<int>());
  // The user has this object already and puts a block around all of it.
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
    const bool is_found =
        object.at("kind") == "OBJECT_KIND_OBJECT" || object.at("kind") == "OBJECT_KIND_RESIDUAL";
    if (!is_found) continue;
    const json& o = object.at("x_world_object");
    EXPECT_GT(std::hypot(o.at("tx_m").get<double>() - centre.at("tx_m").get<double>(),
                         o.at("ty_m").get<double>() - centre.at("ty_m").get<double>()),
              0.03)
        << name << " was made of points that the user's object explains";
  }
}

}  // namespace
}  // namespace cwm::testing
