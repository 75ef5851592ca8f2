#include "collision/query/self_collisions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/robot/kinematics.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::IsEmpty;

struct Loaded {
  std::shared_ptr<const RobotGeometry> robot;
  SelfCollisions found;
};

// The balls of ThreeBalls are 0.1 m in radius and 0.5 m apart; `more` are further links.
Loaded Load(const std::string& more, const std::string& srdf, std::vector<double> state = {0, 0}) {
  const auto description =
      *ReadUrdf(testing::Robot(testing::ThreeBalls() + more), testing::NoMeshes);
  const auto semantic = *ReadSrdf("<robot name=\"r\">" + srdf + "</robot>", description);
  const auto robot = PrepareRobot(*MakeRobotModel(description, &semantic), std::nullopt);
  return {robot, *FindSelfCollisions(*robot, state)};
}

std::string NamesOf(const Loaded& loaded, const LinkPair& pair) {
  const auto& links = loaded.robot->model->links;
  return links[static_cast<std::size_t>(pair.first)].name +
         links[static_cast<std::size_t>(pair.second)].name;
}

// A ball that rides on the link c, 0.15 m beside its ball, meets it in every state.
TEST(SelfCollisions, NamePairsThatAlwaysCollide) {
  const std::string beside =
      testing::Ball("f") + testing::JointText("swivel", "continuous", "c", "f",
                                              "<origin xyz=\"0 0 0.15\"/><axis xyz=\"0 0 1\"/>");
  const Loaded loaded = Load(beside, "", {0, 0, 0});
  ASSERT_EQ(loaded.found.always.size(), 1u);
  EXPECT_EQ(NamesOf(loaded, loaded.found.always[0]), "cf");
  EXPECT_THAT(loaded.found.states, IsEmpty()) << "that pair says nothing about a state";
  EXPECT_THAT(Load(beside, "<disable_collisions link1=\"c\" link2=\"f\"/>", {0, 0, 0}).found.always,
              IsEmpty());
}

TEST(SelfCollisions, NameStatesWithAnotherPair) {
  const std::string states =
      "<group name=\"g\"><joint name=\"shoulder\"/><joint name=\"elbow\"/></group>"
      "<group_state name=\"straight\" group=\"g\"><joint name=\"elbow\" value=\"0\"/></group_state>"
      "<group_state name=\"folded\" group=\"g\"><joint name=\"elbow\" value=\"3\"/></group_state>";
  const Loaded loaded = Load("", states, {0, -2.9});
  EXPECT_THAT(loaded.found.always, IsEmpty());
  ASSERT_EQ(loaded.found.states.size(), 2u);
  EXPECT_EQ(loaded.found.states[0].state, "") << "the given state";
  EXPECT_EQ(NamesOf(loaded, loaded.found.states[0].links), "ae");
  EXPECT_EQ(loaded.found.states[1].group, "g");
  EXPECT_EQ(loaded.found.states[1].state, "folded");
}

// The other joints are at their defaults, for which a state of some joints cannot be blamed.
TEST(SelfCollisions, BlameStatesForPairsThatTheirGroupMoves) {
  const std::string tip =
      testing::Ball("t") +
      testing::JointText("wrist", "revolute", "e", "t",
                         "<origin xyz=\"0.3 0 0\"/><limit lower=\"-1\" upper=\"1\"/>");
  const std::string states =
      "<group name=\"hand\"><joint name=\"wrist\"/></group>"
      "<group_state name=\"still\" group=\"hand\"><joint name=\"wrist\" "
      "value=\"0.1\"/></group_state>"
      "<group name=\"arm\"><joint name=\"elbow\"/></group>"
      "<group_state name=\"folded\" group=\"arm\"><joint name=\"elbow\" "
      "value=\"3\"/></group_state>";
  const Loaded loaded = Load(tip, states, {0, 3, 0});
  ASSERT_EQ(loaded.found.states.size(), 2u);
  EXPECT_EQ(loaded.found.states[0].state, "");
  EXPECT_EQ(loaded.found.states[1].state, "folded");
}

TEST(SelfCollisions, EndWithTheWork) {
  class Ended final : public WorkCounter {
    bool MustEndAfter(std::size_t) override { return true; }
    bool MustEndNow() override { return true; }
  } work;
  const auto loaded = Load("", "");
  EXPECT_FALSE(FindSelfCollisions(*loaded.robot, std::vector<double>{0, 0}, &work).has_value());
}

}  // namespace
}  // namespace cwm::collision
