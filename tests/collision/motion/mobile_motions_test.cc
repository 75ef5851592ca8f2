// Motions of mobile and flying robots, against dense samples.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "collision/motion/check_paths.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/motion/dense_samples.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;

// A long box, whose ends sweep if it turns.
std::string Beam(const std::string& name) {
  return "<link name=\"" + name +
         "\"><collision><geometry><box size=\"0.5 0.06 0.06\"/></geometry></collision></link>\n";
}

// A robot and a body of it.
struct Asking {
  explicit Asking(const std::string& elements) {
    const auto description = ReadUrdf(Robot(elements), NoMeshes);
    EXPECT_TRUE(description.ok()) << description.status();
    model = *MakeRobotModel(*description, nullptr);
    robot = PrepareRobot(model, std::nullopt);
    body = BodyFromRobot(*robot, RobotScope::kBoth);
  }
  std::shared_ptr<const RobotModel> model;
  std::shared_ptr<const RobotGeometry> robot;
  QueryBody body;
};

// A mobile beam on a plane, with another beam at the end of an arm.
Asking Driver() {
  const std::string up = "<axis xyz=\"0 0 1\"/>";
  return Asking(Links("w") + Beam("base") + Beam("hand") +
                JointText("drive", "planar", "w", "base", up) +
                JointText("elbow", "revolute", "base", "hand",
                          "<origin xyz=\"0.2 0 0.1\"/><axis xyz=\"0 1 0\"/>"
                          "<limit lower=\"-3\" upper=\"3\"/>"));
}

// A flying beam with a gripper that slides out.
Asking Flyer() {
  return Asking(Links("w") + Beam("base") + Beam("hand") +
                JointText("fly", "floating", "w", "base", "") +
                JointText("slide", "prismatic", "base", "hand",
                          "<origin xyz=\"0 0 0.1\" rpy=\"0 0 1\"/><axis xyz=\"1 0 0\"/>"
                          "<limit lower=\"-0.3\" upper=\"0.3\"/>"));
}

// Positions within 0.9 m of the origin; values of joints with limits within these.
std::vector<double> RandomState(const RobotModel& model, std::mt19937& random) {
  constexpr int kQw = 6;  // the last of a floating joint's variables
  std::vector<double> state;
  for (const Variable& variable : model.variables) {
    const JointKind kind = model.links[static_cast<std::size_t>(variable.link)].kind;
    const bool is_heading = kind == JointKind::kPlanar && variable.component == 2;
    const double most = is_heading ? std::numbers::pi : std::min(0.9, variable.upper);
    state.push_back(std::uniform_real_distribution<double>(-most, most)(random));
    if (variable.component == kQw) Eigen::Map<Eigen::Vector4d>(&state.back() - 3).normalize();
  }
  return state;
}

TEST(MobileMotions, AreNeverWrongByDenseSamples) {
  std::mt19937 random(11);
  const auto world = RandomWorld(16, random, true);
  for (const Asking& asking : {Driver(), Flyer()}) {
    std::vector<std::unique_ptr<BodyMotion>> edges;
    for (int k = 0; k < 150; ++k) {
      const auto from = RandomState(*asking.model, random), to = RandomState(*asking.model, random);
      edges.push_back(
          std::make_unique<JointMotion>(*asking.model, asking.body, Pose::Identity(), from, to));
    }
    const MotionColumns columns = *CheckMotions(*world, asking.body, edges, {});
    Tally result;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      ExpectTrue(*world, asking.body, *edges[k], columns, k, 400, result);
    }
    EXPECT_GT(result.free, 10);
    EXPECT_GT(result.contact, 10);
    EXPECT_EQ(result.other, 0);
  }
}

TEST(MobileMotions, AreWholePathsToo) {
  std::mt19937 random(12);
  const auto world = RandomWorld(8, random, true);
  for (const Asking& asking : {Driver(), Flyer()}) {
    const RobotModel& model = *asking.model;
    constexpr std::size_t kPaths = 60, kRows = 4;
    std::vector<double> rows;
    std::vector<Path> paths;
    for (std::size_t k = 0; k < kPaths * kRows; ++k) {
      const std::vector<double> state = RandomState(model, random);
      rows.insert(rows.end(), state.begin(), state.end());
      if (k % kRows == 0) paths.push_back({.first_row = k, .row_count = kRows});
    }
    const JointRows states(model, model.all, {.base = DefaultVariables(model), .rows = rows});
    const JointWaypoints waypoints(model, asking.body, states);
    const MotionColumns result = *CheckPaths(*world, asking.body, waypoints, paths, {});
    std::vector<std::unique_ptr<BodyMotion>> edges;
    for (std::size_t row = 0; row + 1 < kPaths * kRows; ++row) {
      edges.push_back(waypoints.MotionFrom(row));
    }
    const MotionColumns by_edge = *CheckMotions(*world, asking.body, edges, {});
    int contacts = 0;
    for (std::size_t k = 0; k < kPaths; ++k) {
      std::int32_t first = -1;  // first edge in contact
      for (std::size_t i = 0; i + 1 < kRows && first < 0; ++i) {
        const bool meets = by_edge.verdict[k * kRows + i] == MotionVerdict::kContact;
        if (meets) first = static_cast<std::int32_t>(i);
      }
      EXPECT_EQ(result.verdict[k] == MotionVerdict::kContact, first >= 0) << k;
      if (first < 0) continue;
      ++contacts;
      EXPECT_EQ(result.segment[k], first) << k;
      EXPECT_EQ(result.hi[k], by_edge.hi[k * kRows + static_cast<std::size_t>(first)]) << k;
    }
    EXPECT_GT(contacts, 10);
    EXPECT_LT(contacts, static_cast<int>(kPaths) - 10);
  }
}

// Turns on the spot through the half turn. The hand reaches 0.45 m ahead; nothing reaches that far
// behind.
TEST(MobileMotions, MeetWhatLiesOnTheShortWay) {
  const Asking driver = Driver();
  const std::vector<double> rows = {0, 0, 2.5, 0, 0, 0, -2.5, 0};
  const JointRows states(*driver.model, driver.model->all,
                         {.base = DefaultVariables(*driver.model), .rows = rows});
  const auto verdict = [&](double x_m) {
    const auto world =
        WorldOf({PutOf("post", {{.shape = Cylinder{0.01, 1}}}, MakeTranslation(x_m, 0, 0))});
    const std::vector<Path> path = {{}};
    return CheckPaths(*world, driver.body, JointWaypoints(*driver.model, driver.body, states), path,
                      {})
        ->verdict;
  };
  EXPECT_THAT(verdict(-0.4), ElementsAre(MotionVerdict::kContact));
  EXPECT_THAT(verdict(0.4), ElementsAre(MotionVerdict::kFree));
}

// All numbers are binary fractions, so that a gap of 0 is exact.
TEST(MobileMotions, SlideOnTheFloorAtAnyLength) {
  const Asking box(Links("w") +
                   "<link name=\"base\"><collision><geometry><box size=\"0.5 0.25 0.125\"/>"
                   "</geometry></collision></link>" +
                   JointText("drive", "planar", "w", "base",
                             "<origin xyz=\"0 0 0.0625\"/><axis xyz=\"0 0 1\"/>"));
  const auto floor = [](double gap_m) {
    return WorldOf(
        {PutOf("floor", {{.shape = Box{{32, 32, 1}}}}, MakeTranslation(0, 0, -0.5 - gap_m))});
  };
  for (const double length_m : {0.01, 0.5, 4.0, 10.0}) {
    const std::vector<double> rows = {0, 0, 0, length_m, 0.25, 1};
    const JointRows states(*box.model, box.model->all,
                           {.base = DefaultVariables(*box.model), .rows = rows});
    const auto result = [&](double gap_m) {
      const std::vector<Path> path = {{}};
      return *CheckPaths(*floor(gap_m), box.body, JointWaypoints(*box.model, box.body, states),
                         path, {});
    };
    EXPECT_THAT(result(0).verdict, ElementsAre(MotionVerdict::kGrazing)) << length_m;
    EXPECT_THAT(result(0x1p-14).verdict, ElementsAre(MotionVerdict::kFree)) << length_m;
    EXPECT_NEAR(result(0x1p-14).clearance_m[0], 0x1p-14, 1e-12) << length_m;
    EXPECT_THAT(result(-0x1p-14).verdict, ElementsAre(MotionVerdict::kContact)) << length_m;
  }
}

// A robot ten kilometres from its joint's origin turns about its own origin.
TEST(MobileMotions, TurnFarFromTheOriginAsTheyDoThere) {
  const Asking driver = Driver();
  const std::vector<double> rows = {1e4, 0, 0, 0, 1e4, 0, 1, 0};
  const JointRows states(*driver.model, driver.model->all,
                         {.base = DefaultVariables(*driver.model), .rows = rows});
  const auto world =
      WorldOf({PutOf("post", {{.shape = Cylinder{0.01, 1}}}, MakeTranslation(1e4, 0.46, 0))});
  const std::vector<Path> path = {{}};
  const MotionColumns result = *CheckPaths(
      *world, driver.body, JointWaypoints(*driver.model, driver.body, states), path, {});
  EXPECT_THAT(result.verdict, ElementsAre(MotionVerdict::kFree));
}

}  // namespace
}  // namespace cwm::collision
