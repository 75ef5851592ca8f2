#include "collision/robot/state_range.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "collision/geometry/validation.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::HasSubstr;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;
using ModelPtr = std::shared_ptr<const RobotModel>;

absl::StatusOr<ModelPtr> Load(const std::string& elements) {
  auto robot = ReadUrdf(Robot(elements), NoMeshes);
  if (!robot.ok()) return robot.status();
  return MakeRobotModel(*std::move(robot), nullptr);
}

std::string RefusalOf(const std::string& elements) {
  return std::string(Load(elements).status().message());
}

std::string FaultOf(const RobotModel& model, const std::vector<double>& state,
                    const Pose& X_WB = Pose::Identity()) {
  return StateFault(model, X_WB, state).value_or("");
}

std::string Far(const std::string& x) { return "<origin xyz=\"" + x + " 0 0\"/>"; }
const char kWide[] = "<limit lower=\"-1e9\" upper=\"1e9\"/>";

TEST(CheckReach, RefusesLinksThatJointsMayTakeTooFar) {
  const std::string two = JointText("j", "continuous", "a", "b", Far("600000")) +
                          JointText("k", "continuous", "b", "c", Far("600000"));
  EXPECT_EQ(RefusalOf(Links("abc") + two),
            "urdf: link \"c\": may be 1.2e+06 m from the root, the origins of the joints between "
            "them added up, must be at most 1e+06 m");
  EXPECT_EQ(RefusalOf(Links("abc") + JointText("j", "continuous", "a", "b", Far("600000")) +
                      JointText("k", "continuous", "b", "c", Far("400000"))),
            "");
}

// Fixed joints cannot turn, so a way there and back ends where it began.
TEST(CheckReach, TakesFixedJointsForWhatTheyAreTogether) {
  EXPECT_EQ(RefusalOf(Links("abcd") + JointText("j", "fixed", "a", "b", Far("900000")) +
                      JointText("k", "fixed", "b", "c", Far("-900000")) +
                      JointText("l", "continuous", "c", "d", Far("900000"))),
            "");
}

TEST(CheckReach, CountsWhatFollowersAreOffsetBy) {
  EXPECT_THAT(RefusalOf(Links("abc") + JointText("j", "prismatic", "a", "b") +
                        JointText("k", "prismatic", "b", "c",
                                  Far("500000") + kWide + "<mimic joint=\"j\" offset=\"6e5\"/>")),
              HasSubstr("link \"c\": may be 1.1e+06 m from the root"));
}

TEST(StateRange, NamesTheLinkThatSlidesTooFar) {
  const ModelPtr model = *Load(Links("abc") + JointText("j", "prismatic", "a", "b", kWide) +
                               JointText("k", "prismatic", "b", "c", kWide));
  EXPECT_EQ(FaultOf(*model, {6e5, 3e5}), "");
  EXPECT_EQ(FaultOf(*model, {6e5, -1e6}), "") << "the sum of lengths alone is too much";
  EXPECT_EQ(
      FaultOf(*model, {6e5, 5e5}),
      "puts link \"c\" at (1.1e+06, 0, 0), must be within 1e+06 m of the world's origin along "
      "each axis");
  EXPECT_THAT(FaultOf(*model, {6e5, 3e5}, MakeTranslation(2e5, 0, 0)), HasSubstr("link \"c\""));
}

TEST(StateRange, NamesTheFollowerThatGoesTooFar) {
  const ModelPtr model =
      *Load(Links("abc") + JointText("j", "continuous", "a", "b", "") +
            JointText("k", "continuous", "b", "c", "<mimic joint=\"j\" multiplier=\"-1000\"/>"));
  EXPECT_EQ(FaultOf(*model, {1000}), "");
  EXPECT_EQ(FaultOf(*model, {1001}),
            "puts joint \"k\", which follows another, at -1.001e+06, must be at most 1e+06 in "
            "magnitude");
}

// Comparisons with NaN must not hide a fault.
TEST(StateRange, FindsLinksThatAreNowhere) {
  const ModelPtr model = *Load(Links("ab") + JointText("j", "prismatic", "a", "b", kWide));
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double value : {infinity, -infinity, std::nan("")}) {
    EXPECT_THAT(FaultOf(*model, {value}), HasSubstr("puts link \"b\" at ("));
  }
}

TEST(StateRange, OfAGroupCountsTheBaseOfTheOthers) {
  const ModelPtr model =
      *Load(Links("abcd") + JointText("j", "prismatic", "a", "b", kWide) +
            JointText("k", "prismatic", "b", "c", kWide) +
            JointText("f", "continuous", "c", "d", "<mimic joint=\"j\" multiplier=\"2\"/>"));
  JointGroup last;
  last.variables = {1};
  const Pose X_WB = Pose::Identity();
  const StateRange near(*model, last, X_WB, {2e5, 7}), far(*model, last, X_WB, {6e5, 7});
  EXPECT_EQ(near.Reach_m(100), 2e5 + 100);
  EXPECT_FALSE(near.FaultOf(std::vector<double>{7e5}).has_value());
  EXPECT_TRUE(near.FaultOf(std::vector<double>{9e5}).has_value());
  EXPECT_GT(far.Reach_m(0), kMaxCoordinate_m);
  EXPECT_THAT(*far.FaultOf(std::vector<double>{0}), HasSubstr("joint \"f\""));
}

TEST(StateRange, OfAnArmThatOnlyTurnsHasNoFaultsAtAll) {
  const ModelPtr model = *Load(testing::ThreeBalls());
  const auto of = [&](double x_m) {
    return StateRange(*model, model->all, MakeTranslation(x_m, 0, 0), {0, 0});
  };
  EXPECT_FALSE(of(kMaxCoordinate_m - 1).MayHaveFaults());
  EXPECT_TRUE(of(kMaxCoordinate_m - 0.99).MayHaveFaults());
  const StateRange edge = of(kMaxCoordinate_m - 0.99);
  EXPECT_TRUE(edge.FaultOf(std::vector<double>{0, 0}).has_value()) << "stretched out";
  EXPECT_FALSE(edge.FaultOf(std::vector<double>{1, 0}).has_value());
}

TEST(StateRange, LooksAtPlanarAndFloatingJoints) {
  const ModelPtr planar =
      *Load(Links("ab") + JointText("j", "planar", "a", "b", Far("5") + "<axis xyz=\"0 0 1\"/>"));
  EXPECT_EQ(FaultOf(*planar, {999990, 0, 2}), "");
  EXPECT_THAT(FaultOf(*planar, {999996, 0, 0}), HasSubstr("link \"b\""));
  const ModelPtr floating = *Load(Links("ab") + JointText("j", "floating", "a", "b", Far("5")));
  EXPECT_EQ(FaultOf(*floating, {0, 1e6, 0, 0, 0, 0, 1}), "");
  EXPECT_THAT(FaultOf(*floating, {0, 1.001e6, 0, 0, 0, 0, 1}), HasSubstr("link \"b\""));
}

}  // namespace
}  // namespace cwm::collision
