// Derivatives of distances by joints: worked out by hand, and against finite differences of the
// distances that the same query returns.
#include "collision/query/joint_gradients.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/query/query.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/query/rod_arm.h"
#include "tests/collision/robot/three_ball_arm.h"
#include "tests/collision/world/test_arm.h"

namespace cwm::collision {
namespace {

using ::testing::ElementsAre;
using testing::JointText;
using testing::MakeChange;

constexpr double kRounding = 1e-12;

// The arm of three balls a, c, e, 0.5 m apart, with the joints shoulder (at a) and elbow (at c).
PairColumns BallArmDistances(const WorldSnapshot& world, const std::vector<double>& row,
                             RobotScope scope) {
  const auto model = testing::ThreeBallArm();
  const auto robot = PrepareRobot(model, std::nullopt);
  const JointRows rows(*model, model->all, {.base = DefaultVariables(*model), .rows = row});
  return *GetDistances(world, BodyFromRobot(*robot, scope), rows, {.joint_gradients = true});
}

TEST(JointGradients, AreLeversAcrossTheNormal) {
  // The outstretched arm ends at x = 1 below a post at y = 1: both joints turn the last ball
  // towards it, the shoulder with a lever of 1 m and the elbow with one of 0.5 m.
  const auto world = WorldOf({BallAt("post", {1, 1, 0}, 0.1)});
  const PairColumns near = BallArmDistances(*world, {0, 0}, RobotScope::kWorld);
  EXPECT_THAT(near.distance_m, AreNear({0.8}, kRounding));
  EXPECT_THAT(near.joint_gradient, AreNear({-1, -0.5}, kRounding));
  EXPECT_THAT(near.gradient_kink, ElementsAre(0));
}

TEST(JointGradients, OfASelfPairCountOnlyJointsBetweenItsLinks) {
  // The balls a and e are cos(elbow / 2) m apart, whatever the shoulder does.
  const double elbow = std::numbers::pi / 2;
  const PairColumns near = BallArmDistances(WorldSnapshot(), {0.3, elbow}, RobotScope::kSelf);
  EXPECT_THAT(near.distance_m, AreNear({std::cos(elbow / 2) - 0.2}, kRounding));
  EXPECT_THAT(near.joint_gradient, AreNear({0, -0.5 * std::sin(elbow / 2)}, kRounding));
}

TEST(JointGradients, OfRowsThatAreNoStatesAreRefused) {
  const auto world = WorldOf({BallAt("post", {1, 1, 0}, 0.1)});
  const QueryBody body = BodyFromShapes({{.X_FS = Pose::Identity(), .shape = Sphere{0.1}}});
  const std::vector<Pose> at = {Pose::Identity()};
  EXPECT_EQ(GetDistances(*world, body, at, {.joint_gradients = true}).status().code(),
            absl::StatusCode::kInvalidArgument);
}

// A slider along x whose link is the geometry.
PairColumns SliderDistances(const WorldSnapshot& world, const std::string& geometry) {
  const std::string urdf =
      testing::Robot("<link name=\"base\"/><link name=\"tool\">" + geometry + "</link>" +
                     JointText("slide", "prismatic", "base", "tool",
                               "<axis xyz=\"1 0 0\"/><limit lower=\"-1\" upper=\"1\"/>"));
  const auto model = *MakeRobotModel(*ReadUrdf(urdf, testing::NoMeshes), nullptr);
  const auto robot = PrepareRobot(model, std::nullopt);
  const std::vector<double> row = {0};
  const JointRows rows(*model, model->all, {.base = {0}, .rows = row});
  return *GetDistances(world, BodyFromRobot(*robot, RobotScope::kWorld), rows,
                       {.joint_gradients = true});
}

std::string ShapeAt(const std::string& xyz, const std::string& shape) {
  return "<collision><origin xyz=\"" + xyz + "\"/><geometry><" + shape +
         "/></geometry></collision>";
}

TEST(JointGradients, AreMarkedWhereTheNearestPointsAreNotUnique) {
  const auto world = WorldOf({BoxAt("wall", {0.2, 2, 2}, MakeTranslation(1, 0, 0))});
  const std::string box = "box size=\"0.2 0.2 0.2\"", ball = "sphere radius=\"0.1\"";
  const PairColumns faces = SliderDistances(*world, ShapeAt("0 0 0", box));
  EXPECT_THAT(faces.joint_gradient, AreNear({-1}, kRounding));
  EXPECT_THAT(faces.gradient_kink, ElementsAre(1));
  EXPECT_THAT(SliderDistances(*world, ShapeAt("0 0 0", ball)).gradient_kink, ElementsAre(0));
  // Two balls of the link are as near, then one is nearer by 1 nm and 1 um.
  const auto kink_of_balls = [&](const std::string& second) {
    return SliderDistances(*world, ShapeAt("0 0.3 0", ball) + ShapeAt(second, ball))
        .gradient_kink[0];
  };
  EXPECT_EQ(kink_of_balls("0 -0.3 0"), 1);
  EXPECT_EQ(kink_of_balls("0.0000000005 -0.3 0"), 1);
  EXPECT_EQ(kink_of_balls("0.000001 -0.3 0"), 0);
}

// A robot with a joint of each kind, which all move the last link: a base on a floating joint, a
// planar one, a rail, an endless waist, an elbow and a wrist that mimics the elbow; and a finger.
std::string EveryJoint(const std::string& shape) {
  const auto link = [&](const std::string& name) {
    return "<link name=\"" + name + "\">" + ShapeAt("0.05 0.02 0.1", shape) + "</link>";
  };
  const std::string limits = "<limit lower=\"-2\" upper=\"2\"/>";
  const std::string at = "<origin xyz=\"0.1 0.05 0.25\" rpy=\"0.3 -0.2 0.7\"/>";
  return testing::Robot(
      "<link name=\"root\"/>" + link("body") + link("sled") + link("rail") + link("waist") +
      link("upper") + link("hand") + link("finger") +
      JointText("float", "floating", "root", "body", "") +
      JointText("plane", "planar", "body", "sled", at + "<axis xyz=\"0.6 0 0.8\"/>") +
      JointText("slide", "prismatic", "sled", "rail", at + "<axis xyz=\"0 0.8 0.6\"/>" + limits) +
      JointText("turn", "continuous", "rail", "waist", at + "<axis xyz=\"0 0 1\"/>") +
      JointText("elbow", "revolute", "waist", "upper", at + "<axis xyz=\"0 1 0\"/>" + limits) +
      JointText("wrist", "revolute", "upper", "hand",
                at + "<axis xyz=\"0 -1 0\"/>" + "<limit lower=\"-2\" upper=\"2\"/>" +
                    "<mimic joint=\"elbow\" multiplier=\"-0.5\" offset=\"0.1\"/>") +
      JointText("grip", "prismatic", "hand", "finger",
                "<origin xyz=\"0 0.1 0\"/><axis xyz=\"1 0 0\"/>" + limits));
}

// The robot among obstacles of one shape, with a box attached to its finger.
class EveryJointRobot {
 public:
  EveryJointRobot(const std::string& shape, const Shape& obstacle, std::mt19937& random) {
    std::vector<Change> changes = {
        MakeChange(
            testing::PutArm("robot", testing::Arm(EveryJoint(shape), "<robot name=\"r\"/>"))),
        BoxAt("held", {0.1, 0.08, 0.06}, Pose::Identity()),
        MakeChange(AttachObject{.name = "held",
                                .robot = "robot",
                                .link = "finger",
                                .X_LO = MakeTranslation(0.1, 0.05, 0.3)})};
    for (int k = 0; k < 6; ++k) {
      changes.push_back(PutOf("obstacle_" + std::to_string(k),
                              {{.X_FS = Pose::Identity(), .shape = obstacle}},
                              RandomPose(random, 0.6)));
    }
    world_ = WorldOf(changes);
    robot_ = world_->FindRobot("robot");
    body_ = WithAttachedObjects(BodyFromRobot(*robot_, RobotScope::kBoth), *world_, *robot_,
                                RobotScope::kBoth);
  }

  // All variables; the quaternion has length 1.
  std::vector<double> RandomState(std::mt19937& random) const {
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> state(robot_->model().variables.size());
    for (double& value : state) value = uniform(random);
    Eigen::Map<Eigen::Vector4d>(&state[3]).normalize();
    return state;
  }

  PairColumns Distances(const std::vector<double>& state, double max_distance_m) const {
    const JointRows rows(robot_->model(), robot_->model().all,
                         {.base = robot_->state, .rows = state});
    return *GetDistances(*world_, body_, rows,
                         {.max_distance_m = max_distance_m,
                          .pairs = DistancePairs::kLinks,
                          .max_results = 0,
                          .joint_gradients = true});
  }

  // The distance of the group of parts that the k-th answer stands for. Each link, and the attached
  // object, has one part.
  static double DistanceOfPair(const PairColumns& answers, const PairColumns& of, std::size_t k) {
    for (std::size_t i = 0; i < answers.distance_m.size(); ++i) {
      const bool is_same = answers.body_part[i] == of.body_part[k] &&
                           answers.object[i] == of.object[k] &&
                           answers.object_part[i] == of.object_part[k];
      if (is_same) return answers.distance_m[i];
    }
    ADD_FAILURE() << "pair not found";
    return 0;
  }

  std::size_t width() const { return robot_->model().variables.size(); }

 private:
  std::shared_ptr<const WorldSnapshot> world_;
  WorldRobotPtr robot_;
  QueryBody body_;
};

struct Errors {
  double worst_apart = 0, worst_overlapping = 0;
  int apart = 0, overlapping = 0, kinks = 0;
};

// Compares the gradients with central differences.
Errors CompareWithDifferences(const std::string& shape, const Shape& obstacle, int states) {
  std::mt19937 random(5);
  const EveryJointRobot robot(shape, obstacle, random);
  constexpr double kStep = 1e-6, kRadius_m = 0.3;
  Errors errors;
  for (int n = 0; n < states; ++n) {
    std::vector<double> state = robot.RandomState(random);
    const PairColumns answers = robot.Distances(state, kRadius_m);
    std::vector<PairColumns> above, below;
    for (double& value : state) {
      const double before = value;
      value = before + kStep;
      above.push_back(robot.Distances(state, 2 * kRadius_m));
      value = before - kStep;
      below.push_back(robot.Distances(state, 2 * kRadius_m));
      value = before;
    }
    for (std::size_t k = 0; k < answers.distance_m.size(); ++k) {
      if (answers.gradient_kink[k] != 0) {
        ++errors.kinks;
        continue;
      }
      const bool is_apart = answers.distance_m[k] > 0;
      ++(is_apart ? errors.apart : errors.overlapping);
      double& worst = is_apart ? errors.worst_apart : errors.worst_overlapping;
      for (std::size_t j = 0; j < robot.width(); ++j) {
        const double difference = (EveryJointRobot::DistanceOfPair(above[j], answers, k) -
                                   EveryJointRobot::DistanceOfPair(below[j], answers, k)) /
                                  (2 * kStep);
        worst =
            std::max(worst, std::abs(difference - answers.joint_gradient[k * robot.width() + j]));
      }
    }
  }
  return errors;
}

const Shape kObstacle = Box{{0.2, 0.3, 0.15}};

TEST(JointGradients, OfBallsAreFiniteDifferencesForEveryKindOfJoint) {
  const Errors errors = CompareWithDifferences("sphere radius=\"0.08\"", kObstacle, 200);
  EXPECT_GT(errors.apart, 500);
  EXPECT_GT(errors.overlapping, 20);
  EXPECT_LT(errors.worst_apart, 1e-7);
  EXPECT_LT(errors.worst_overlapping, 1e-7);
  EXPECT_EQ(errors.kinks, 0);
}

TEST(JointGradients, OfBoxesAreFiniteDifferencesForEveryKindOfJoint) {
  const Errors errors = CompareWithDifferences("box size=\"0.1 0.16 0.12\"", kObstacle, 200);
  EXPECT_GT(errors.apart, 500);
  EXPECT_GT(errors.overlapping, 20);
  EXPECT_GT(errors.kinks, 20);  // the finger slides parallel to the hand
  EXPECT_LT(errors.worst_apart, 1e-7);
  EXPECT_LT(errors.worst_overlapping, 1e-7);
}

TEST(JointGradients, OfMeshesAreFiniteDifferences) {
  const Shape mesh = MakeMesh(Tessellate(Shape(Capsule{0.15, 0.3}), 2e-3));
  const Errors errors = CompareWithDifferences("sphere radius=\"0.08\"", mesh, 80);
  EXPECT_GT(errors.apart, 200);
  EXPECT_GT(errors.overlapping, 10);
  EXPECT_LT(errors.worst_apart, 1e-7);
  EXPECT_LT(errors.worst_overlapping, 1e-7);
}

}  // namespace
}  // namespace cwm::collision
