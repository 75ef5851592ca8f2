#include "collision/robot/kinematics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using testing::JointText;
using testing::Links;
using testing::NoMeshes;
using testing::Robot;
using ModelPtr = std::shared_ptr<const RobotModel>;

// derived: a dozen products of rotations, each with an error of a few units in the last place.
constexpr double kRounding = 1e-14;

ModelPtr ModelOf(const std::string& elements, const std::string& srdf = "") {
  const auto robot = ReadUrdf(Robot(elements), NoMeshes);
  EXPECT_TRUE(robot.ok()) << robot.status();
  const auto semantic = ReadSrdf(Robot(srdf), *robot);
  EXPECT_TRUE(semantic.ok()) << semantic.status();
  return *MakeRobotModel(*robot, &*semantic);
}

std::vector<Pose> PosesOf(const RobotModel& model, const Pose& X_WB,
                          const std::vector<double>& variables) {
  std::vector<Pose> poses(model.links.size());
  LinkPoses(model, X_WB, variables, poses);
  return poses;
}

// Rodrigues' formula, written out.
Matrix3 Rotation(const Vector3& axis, double angle_rad) {
  Matrix3 K;
  K << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
  return Matrix3::Identity() + std::sin(angle_rad) * K + (1 - std::cos(angle_rad)) * K * K;
}

Pose Turn(const Vector3& axis, double angle_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = Rotation(axis, angle_rad);
  return pose;
}

Pose Shift(const Vector3& by_m) { return MakeTranslation(by_m.x(), by_m.y(), by_m.z()); }

const Pose kOrigin = Shift({0.1, -0.2, 0.3}) * Turn(Vector3::UnitZ(), 0.3) *
                     Turn(Vector3::UnitY(), -0.4) * Turn(Vector3::UnitX(), 0.5);
const char kOriginText[] = "<origin xyz=\"0.1 -0.2 0.3\" rpy=\"0.5 -0.4 0.3\"/>";
const Vector3 kAxis = Vector3(1, -2, 2) / 3;
const char kAxisText[] = "<axis xyz=\"1 -2 2\"/>";
const Pose kBase = Shift({1, 2, 3}) * Turn(Vector3(0.6, 0, 0.8), 1.2);

// The pose of the second of two links under a joint of that kind.
Pose PoseUnder(const std::string& kind, const std::vector<double>& variables) {
  const ModelPtr model = ModelOf(Links("ab") + JointText("j", kind, "a", "b",
                                                         std::string(kOriginText) + kAxisText +
                                                             "<limit lower=\"-9\" upper=\"9\"/>"));
  EXPECT_EQ(model->variables.size(), variables.size());
  return PosesOf(*model, kBase, variables)[1];
}

TEST(Kinematics, EachKindOfJointMovesAsItsDefinitionSays) {
  const auto expect = [](const Pose& actual, const Pose& motion, const char* what) {
    const Pose X_WC = kBase * kOrigin * motion;
    EXPECT_TRUE(actual.isApprox(X_WC, kRounding)) << what;
  };
  expect(PoseUnder("fixed", {}), Pose::Identity(), "fixed");
  expect(PoseUnder("revolute", {0.7}), Turn(kAxis, 0.7), "revolute");
  expect(PoseUnder("continuous", {-8.5}), Turn(kAxis, -8.5), "continuous");
  expect(PoseUnder("prismatic", {0.25}), Shift(0.25 * kAxis), "prismatic");
  const Quaternion turn(Rotation(kAxis, 0.9));
  expect(PoseUnder("floating", {4, 5, 6, turn.x(), turn.y(), turn.z(), turn.w()}),
         Shift({4, 5, 6}) * Turn(kAxis, 0.9), "floating");
}

TEST(Kinematics, APlanarJointMovesInThePlanePerpendicularToItsAxis) {
  const Pose X_WC = PoseUnder("planar", {0.5, -0.25, 0.7});
  const Pose motion = (kBase * kOrigin).inverse() * X_WC;
  EXPECT_NEAR(motion.translation().dot(kAxis), 0, kRounding);
  EXPECT_NEAR(motion.translation().norm(), std::hypot(0.5, 0.25), kRounding);
  EXPECT_TRUE(motion.linear().isApprox(Rotation(kAxis, 0.7), kRounding));
}

TEST(Kinematics, APlanarJointAboutZMovesAlongXAndY) {
  const ModelPtr model =
      ModelOf(Links("ab") + JointText("j", "planar", "a", "b", "<axis xyz=\"0 0 1\"/>"));
  const Pose X_WC = PosesOf(*model, Pose::Identity(), {0.5, -0.25, 0.7})[1];
  EXPECT_TRUE(X_WC.isApprox(Shift({0.5, -0.25, 0}) * Turn(Vector3::UnitZ(), 0.7), kRounding));
}

TEST(Kinematics, QuaternionsOfFloatingJointsAreNormalised) {
  const ModelPtr model = ModelOf(Links("ab") + JointText("j", "floating", "a", "b", ""));
  const Pose turned = PosesOf(*model, Pose::Identity(), {0, 0, 0, 0, 0, 3, 3})[1];
  EXPECT_TRUE(turned.isApprox(Turn(Vector3::UnitZ(), std::numbers::pi / 2), kRounding));
  const Pose none = PosesOf(*model, Pose::Identity(), {1, 0, 0, 0, 0, 0, 0})[1];
  EXPECT_TRUE(none.isApprox(Shift({1, 0, 0}), 0));
}

// A tree whose file names children first: two branches, with a mimic joint on the second.
const std::string kTree =
    Links("edcba") +
    JointText("de", "revolute", "d", "e",
              std::string(kOriginText) +
                  "<limit/><axis xyz=\"0 0 1\"/><mimic joint=\"ab\" multiplier=\"-2\" "
                  "offset=\"0.1\"/>") +
    JointText("ad", "prismatic", "a", "d",
              "<axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"1\"/>") +
    JointText("bc", "continuous", "b", "c", std::string(kOriginText) + "<axis xyz=\"0 1 0\"/>") +
    JointText("ab", "revolute", "a", "b",
              std::string(kOriginText) + "<limit lower=\"-3\" upper=\"3\"/>");

Pose PoseOf(const RobotModel& model, const std::vector<Pose>& poses, const std::string& link) {
  return poses[*model.FindLink(link)];
}

TEST(Kinematics, ATreeIsTheProductOfItsJointsAndFollowers) {
  const ModelPtr model = ModelOf(kTree);
  std::vector<double> variables(3);
  const auto set = [&](const std::string& joint, double value) {
    variables[model->links[*model->FindJoint(joint)].variable] = value;
  };
  set("ab", 0.4);
  set("bc", -1.1);
  set("ad", 0.6);
  const std::vector<Pose> poses = PosesOf(*model, kBase, variables);
  const Pose X_WB = kBase * kOrigin * Turn(Vector3::UnitX(), 0.4);
  const Pose X_WD = kBase * Shift({0, 0.6, 0});
  EXPECT_TRUE(PoseOf(*model, poses, "a").isApprox(kBase, 0));
  EXPECT_TRUE(PoseOf(*model, poses, "b").isApprox(X_WB, kRounding));
  EXPECT_TRUE(PoseOf(*model, poses, "c")
                  .isApprox(X_WB * kOrigin * Turn(Vector3::UnitY(), -1.1), kRounding));
  EXPECT_TRUE(PoseOf(*model, poses, "d").isApprox(X_WD, kRounding));
  EXPECT_TRUE(PoseOf(*model, poses, "e")
                  .isApprox(X_WD * kOrigin * Turn(Vector3::UnitZ(), -2 * 0.4 + 0.1), kRounding));
}

TEST(Kinematics, MovingAGroupGivesThePosesOfTheWholeStateAndTouchesNoOtherLink) {
  const ModelPtr model = ModelOf(kTree, "<group name=\"g\"><joint name=\"ab\"/></group>");
  const JointGroup& group = *model->FindGroup("g");
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(-1, 1);
  std::vector<double> variables = {value(random), value(random), value(random)};
  std::vector<Pose> poses = PosesOf(*model, kBase, variables);
  const Pose marked = Shift({7, 7, 7});
  poses[*model->FindLink("d")] = poses[*model->FindLink("d")] * marked;
  for (const int i : group.variables) variables[i] = value(random);
  MovedLinkPoses(*model, group, variables, poses);
  std::vector<Pose> expected = PosesOf(*model, kBase, variables);
  EXPECT_TRUE(PoseOf(*model, poses, "b").isApprox(PoseOf(*model, expected, "b"), 0));
  EXPECT_TRUE(PoseOf(*model, poses, "c").isApprox(PoseOf(*model, expected, "c"), 0));
  EXPECT_TRUE(PoseOf(*model, poses, "d").isApprox(PoseOf(*model, expected, "d") * marked, 0));
  // The joint above e mimics ab, and its parent is d, which is the marked link.
  EXPECT_TRUE(PoseOf(*model, poses, "e")
                  .isApprox(PoseOf(*model, expected, "d") * marked *
                                PoseOf(*model, expected, "d").inverse() *
                                PoseOf(*model, expected, "e"),
                            kRounding));
}

TEST(Kinematics, TheFirstVariableOutsideItsLimitsIsNamed) {
  const ModelPtr model = ModelOf(kTree);
  ASSERT_THAT(model->all.joints, ElementsAre("ad", "ab", "bc"));
  const int ad = 0, ab = 1, bc = 2;  // limits 0 to 1, -3 to 3, none
  const auto first = [&](double of_ad, double of_ab, double of_bc) {
    return OutOfLimits(*model, std::vector<double>{of_ad, of_ab, of_bc});
  };
  EXPECT_EQ(first(0, -3, 1e9), std::nullopt);
  EXPECT_EQ(first(1, 3, -1e9), std::nullopt);
  EXPECT_EQ(first(std::nextafter(1, 2), 0, 0), ad);
  EXPECT_EQ(first(0, std::nextafter(-3, -4), 0), ab);
  EXPECT_EQ(first(-0.1, 9, 0), ad);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(first(0, nan, nan), ab);
  EXPECT_EQ(first(0, 0, nan), bc);
  EXPECT_EQ(first(0, 0, std::numeric_limits<double>::infinity()), bc);
}

TEST(Kinematics, TheQuaternionOfAFloatingJointHasALimitOfItsOwn) {
  const ModelPtr model = ModelOf(Links("ab") + JointText("j", "floating", "a", "b", ""));
  EXPECT_EQ(OutOfLimits(*model, std::vector<double>{1e3, 0, 0, 0.6, 0, 0, -0.8}), std::nullopt);
  EXPECT_EQ(OutOfLimits(*model, std::vector<double>{0, 0, 0, 0, 0, 0, 1.0099}), std::nullopt);
  EXPECT_EQ(OutOfLimits(*model, std::vector<double>{0, 0, 0, 0, 0, 0, 1.0101}), 3);
  EXPECT_EQ(OutOfLimits(*model, std::vector<double>{0, 0, 0, 0, 0, 0, 0}), 3);
}

TEST(Kinematics, DefaultsAreZeroOrTheMiddleOfLimitsThatExcludeIt) {
  const ModelPtr model = ModelOf(
      Links("abcd") + JointText("j", "revolute", "a", "b", "<limit lower=\"1\" upper=\"2\"/>") +
      JointText("k", "revolute", "b", "c", "<limit lower=\"-1\" upper=\"3\"/>") +
      JointText("l", "floating", "c", "d", ""));
  const std::vector<double> values = DefaultVariables(*model);
  EXPECT_THAT(values, ElementsAre(1.5, 0, 0, 0, 0, 0, 0, 0, 1));
  EXPECT_EQ(OutOfLimits(*model, values), std::nullopt);
}

// Every kind of joint that the SIMD code takes, about z and about another axis, with a mimic joint.
std::string ManyJoints() {
  const std::string limits = "<limit lower=\"-9e9\" upper=\"9e9\"/>";
  return Links("abcdefg") + JointText("j1", "revolute", "a", "b", kOriginText + limits) +
         JointText("j2", "continuous", "b", "c", std::string(kOriginText) + kAxisText) +
         JointText("j3", "prismatic", "c", "d", std::string(kOriginText) + kAxisText + limits) +
         JointText("j4", "fixed", "d", "e", kOriginText) +
         JointText("j5", "revolute", "b", "f",
                   "<axis xyz=\"0 0 1\"/><mimic joint=\"j2\" multiplier=\"-2\" offset=\"0.1\"/>" +
                       limits) +
         JointText("j6", "continuous", "f", "g", "<axis xyz=\"0 0 1\"/>");
}

TEST(LinkPosesOfStates, AreThoseOfEachState) {
  constexpr double kOfSines = 1e-13;  // six joints, a few units in the last place each
  const std::string whole = Links("ab") + JointText("j", "floating", "a", "b", kOriginText);
  for (const ModelPtr& model : {ModelOf(ManyJoints()), ModelOf(whole)}) {
    const std::size_t width = model->variables.size(), links = model->links.size();
    std::mt19937 random(7);
    std::uniform_real_distribution<double> value(-4, 4);
    for (const std::size_t count : {1U, 3U, 8U, 21U}) {
      std::vector<double> states(count * width);
      for (double& v : states) v = value(random);
      states.back() = 1e7;  // many turns: too many for the SIMD code
      std::vector<Pose> together(count * links), alone(links);
      LinkPosesOfStates(*model, kBase, states, together);
      for (std::size_t k = 0; k < count; ++k) {
        const std::vector<double> state(
            states.begin() + static_cast<std::ptrdiff_t>(k * width),
            states.begin() + static_cast<std::ptrdiff_t>((k + 1) * width));
        const std::vector<Pose> plain = PosesOf(*model, kBase, state);
        LinkPosesOfStates(*model, kBase, state, alone);
        for (std::size_t link = 0; link < links; ++link) {
          const Pose& X_WL = together[k * links + link];
          EXPECT_EQ(X_WL.matrix(), alone[link].matrix()) << "state " << k << " of " << count;
          EXPECT_LT((X_WL.matrix() - plain[link].matrix()).norm(),
                    kOfSines * plain[link].matrix().norm())
              << "state " << k << " of " << count << ", link " << link;
        }
      }
    }
  }
}

}  // namespace
}  // namespace cwm::collision
