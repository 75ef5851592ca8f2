#include "collision/motion/body_motion.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "collision/geometry/support.h"
#include "collision/robot/kinematics.h"
#include "tests/collision/query/random_world.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::Ball;
using testing::JointText;
using testing::NoMeshes;
using testing::Robot;

constexpr double kRounding_m = 1e-12;

std::shared_ptr<const RobotGeometry> RobotOf(const std::string& elements) {
  const auto description = ReadUrdf(Robot(elements), NoMeshes);
  EXPECT_TRUE(description.ok()) << description.status();
  return PrepareRobot(*MakeRobotModel(*description, nullptr), std::nullopt);
}

// Moving joints of each kind in a chain, and one that mimics the first.
std::shared_ptr<const RobotGeometry> Snake() {
  const std::string at = "<origin xyz=\"0.3 0.1 0\" rpy=\"0.4 0.2 -0.7\"/>";
  const std::string axis = "<axis xyz=\"0.3 -0.5 0.8\"/>";
  const std::string limits = "<limit lower=\"-2\" upper=\"2\"/>";
  return RobotOf(
      Ball("a") + Ball("b") + Ball("c") + Ball("d") + Ball("e") +
      JointText("turn", "revolute", "a", "b", at + axis + limits) +
      JointText("slide", "prismatic", "b", "c", at + axis + limits) +
      JointText("roll", "continuous", "c", "d", at + axis) +
      JointText("also", "revolute", "d", "e",
                at + axis + limits + "<mimic joint=\"turn\" multiplier=\"-1.5\" offset=\"0.2\"/>"));
}

// A hand carried by a mobile base: planar, revolute, floating and prismatic joints in a chain.
std::shared_ptr<const RobotGeometry> Rover() {
  const std::string at = "<origin xyz=\"0.3 0.1 0\" rpy=\"0.4 0.2 -0.7\"/>";
  const std::string axis = "<axis xyz=\"0.3 -0.5 0.8\"/>";
  const std::string limits = "<limit lower=\"-2\" upper=\"2\"/>";
  return RobotOf(Ball("a") + Ball("b") + Ball("c") + Ball("d") + Ball("e") +
                 JointText("drive", "planar", "a", "b", at + axis) +
                 JointText("turn", "revolute", "b", "c", at + axis + limits) +
                 JointText("fly", "floating", "c", "d", at) +
                 JointText("slide", "prismatic", "d", "e", at + axis + limits));
}

std::vector<double> RandomState(const RobotModel& model, std::mt19937& random) {
  constexpr int kQw = 6;  // the last of a floating joint's variables
  std::vector<double> state;
  for (const Variable& variable : model.variables) {
    state.push_back(std::uniform_real_distribution<double>(-2, 2)(random));
    if (variable.component == kQw) Eigen::Map<Eigen::Vector4d>(&state.back() - 3).normalize();
  }
  return state;
}

// A random point in the part's bounding box, in the part's frame of the body.
Vector3 PointOf(const PreparedPart& part, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0, 1);
  const Vector3 s(share(random), share(random), share(random));
  return part.bounds_O.min() + s.cwiseProduct(part.bounds_O.sizes());
}

TEST(RigidMotion, NoPointTravelsFartherThanItsPart) {
  std::mt19937 random(1);
  const QueryBody body = Gripper();
  double closest = 0;
  for (int k = 0; k < 300; ++k) {
    const RigidMotion motion{body, RandomPose(random, 0.2), RandomPose(random, 0.2)};
    const double from = std::uniform_real_distribution<double>(0, 1)(random);
    const double to = std::uniform_real_distribution<double>(from, 1)(random);
    Pose X_from, X_to;
    motion.Place(from, {&X_from, 1});
    motion.Place(to, {&X_to, 1});
    for (std::int32_t part = 0; part < 2; ++part) {
      const PreparedPart& prepared = body.geometry->parts[static_cast<std::size_t>(part)];
      const Vector3 p = PointOf(prepared, random);
      const double moved_m = (X_to * p - X_from * p).norm();
      const double bound_m = motion.Travel_m(part) * (to - from);
      EXPECT_LE(moved_m, bound_m + kRounding_m);
      closest = std::max(closest, moved_m / bound_m);
    }
  }
  EXPECT_GT(closest, 0.5);  // the bound is not too loose
}

TEST(RigidMotion, NoPointTravelsFartherAlongADirectionThanItsPart) {
  std::mt19937 random(2);
  const QueryBody body = Gripper();
  for (int k = 0; k < 300; ++k) {
    const RigidMotion motion{body, RandomPose(random, 0.2), RandomPose(random, 0.2)};
    const double from = std::uniform_real_distribution<double>(0, 1)(random);
    const double to = std::uniform_real_distribution<double>(from, 1)(random);
    const Vector3 nhat = RandomPose(random, 0).linear().col(0);
    Pose X_from, X_to;
    motion.Place(from, {&X_from, 1});
    motion.Place(to, {&X_to, 1});
    for (std::int32_t part = 0; part < 2; ++part) {
      const Vector3 p = PointOf(body.geometry->parts[static_cast<std::size_t>(part)], random);
      const double moved_m = nhat.dot(X_to * p - X_from * p);
      EXPECT_LE(moved_m, motion.TravelAlong_m(part, nhat) * (to - from) + kRounding_m);
      EXPECT_LE(-moved_m, motion.TravelAlong_m(part, -nhat) * (to - from) + kRounding_m);
    }
  }
}

TEST(RigidMotion, TravelsNotAtAllAlongWhatItTurnsAbout) {
  Pose to = MakeTranslation(1, 2, 0);
  to.linear() = Eigen::AngleAxisd(1, Vector3::UnitZ()).toRotationMatrix();
  const RigidMotion motion(Gripper(), Pose::Identity(), to);
  EXPECT_EQ(motion.TravelAlong_m(0, Vector3::UnitZ()), 0);
}

TEST(RigidMotion, BeginsAndEndsAtItsPosesAndTurnsTheShortWay) {
  const Pose from = MakeTranslation(1, 2, 3);
  Pose to = MakeTranslation(2, 2, 3);
  to.rotate(Eigen::AngleAxisd(1.5 * std::numbers::pi, Vector3::UnitZ()));
  const RigidMotion motion(Gripper(), from, to);
  Pose at;
  motion.Place(0, {&at, 1});
  EXPECT_TRUE(at.isApprox(from, 1e-14));
  motion.Place(1, {&at, 1});
  EXPECT_TRUE(at.isApprox(to, 1e-14));
  motion.Place(0.5, {&at, 1});
  const Eigen::AngleAxisd eighth(-std::numbers::pi / 4, Vector3::UnitZ());
  EXPECT_TRUE(at.linear().isApprox(eighth.toRotationMatrix(), 1e-14));
  EXPECT_TRUE(at.translation().isApprox(Vector3(1.5, 2, 3)));
}

void ExpectNoPointTravelsFartherThanItsPart(const RobotGeometry& of) {
  std::mt19937 random(2);
  const RobotGeometry* const robot = &of;
  const RobotModel& model = *robot->model;
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  double closest = 0;
  for (int k = 0; k < 500; ++k) {
    const Pose X_WB = RandomPose(random, 1);
    const JointMotion motion{model, body, X_WB, RandomState(model, random),
                             RandomState(model, random)};
    const double from = std::uniform_real_distribution<double>(0, 1)(random);
    const double to = std::uniform_real_distribution<double>(from, 1)(random);
    std::vector<Pose> X_from(model.links.size()), X_to(model.links.size());
    motion.Place(from, X_from);
    motion.Place(to, X_to);
    for (std::int32_t part = 0; part < 5; ++part) {
      const auto link = static_cast<std::size_t>(robot->link_of_part[part]);
      const Vector3 p = PointOf(robot->geometry->parts[part], random);
      const double moved_m = (X_to[link] * p - X_from[link] * p).norm();
      const double bound_m = motion.Travel_m(part) * (to - from);
      EXPECT_LE(moved_m, bound_m + kRounding_m) << part;
      if (part == 4) closest = std::max(closest, moved_m / bound_m);
      for (std::int32_t other = 0; other < part; ++other) {
        // The travel in the frame of the other part.
        const auto seen_from = static_cast<std::size_t>(robot->link_of_part[other]);
        const double seen_m = (X_to[seen_from].inverse() * X_to[link] * p -
                               X_from[seen_from].inverse() * X_from[link] * p)
                                  .norm();
        EXPECT_LE(seen_m, motion.RelativeTravel_m({other, part}) * (to - from) + kRounding_m);
      }
    }
  }
  EXPECT_GT(closest, 0.3);
}

TEST(JointMotion, NoPointTravelsFartherThanItsPart) {
  ExpectNoPointTravelsFartherThanItsPart(*Snake());
  ExpectNoPointTravelsFartherThanItsPart(*Rover());
}

void ExpectNoPointTravelsFartherAlongADirection(const RobotGeometry& robot) {
  std::mt19937 random(3);
  const RobotModel& model = *robot.model;
  const QueryBody body = BodyFromRobot(robot, RobotScope::kBoth);
  int is_less = 0;
  for (int k = 0; k < 500; ++k) {
    const std::vector<double> first = RandomState(model, random);
    std::vector<double> last = RandomState(model, random);
    // Joints that do not move leave those behind them steady.
    for (std::size_t v = 0; v < last.size(); ++v) {
      if (model.links[static_cast<std::size_t>(model.variables[v].link)].urdf_index <= k % 5) {
        last[v] = first[v];
      }
    }
    const JointMotion motion(model, body, RandomPose(random, 1), first, last);
    const double from = std::uniform_real_distribution<double>(0, 1)(random);
    const double to = std::uniform_real_distribution<double>(from, 1)(random);
    const Vector3 nhat = RandomPose(random, 0).linear().col(0);
    std::vector<Pose> X_from(model.links.size()), X_to(model.links.size());
    motion.Place(from, X_from);
    motion.Place(to, X_to);
    for (std::int32_t part = 0; part < 5; ++part) {
      const auto link =
          static_cast<std::size_t>(robot.link_of_part[static_cast<std::size_t>(part)]);
      const Vector3 p = PointOf(robot.geometry->parts[static_cast<std::size_t>(part)], random);
      const double moved_m = nhat.dot(X_to[link] * p - X_from[link] * p);
      EXPECT_LE(moved_m, motion.TravelAlong_m(part, nhat) * (to - from) + kRounding_m) << part;
      EXPECT_LE(-moved_m, motion.TravelAlong_m(part, -nhat) * (to - from) + kRounding_m) << part;
      EXPECT_LE(motion.TravelAlong_m(part, nhat), motion.Travel_m(part) + kRounding_m);
      if (motion.TravelAlong_m(part, nhat) < 0.5 * motion.Travel_m(part)) ++is_less;
    }
  }
  EXPECT_GT(is_less, 100);
}

TEST(JointMotion, NoPointTravelsFartherAlongADirectionThanItsPart) {
  ExpectNoPointTravelsFartherAlongADirection(*Snake());
  ExpectNoPointTravelsFartherAlongADirection(*Rover());
}

TEST(JointMotion, BeginsAndEndsAtItsRows) {
  std::mt19937 random(4);
  for (const auto& robot : {Snake(), Rover()}) {
    const RobotModel& model = *robot->model;
    const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
    for (int k = 0; k < 100; ++k) {
      const std::vector<double> from = RandomState(model, random), to = RandomState(model, random);
      const JointMotion motion(model, body, Pose::Identity(), from, to);
      std::vector<Pose> X_WL(model.links.size()), X_row(model.links.size());
      for (const auto& [fraction, row] : {std::pair{0.0, from}, std::pair{1.0, to}}) {
        motion.Place(fraction, X_WL);
        LinkPoses(model, Pose::Identity(), row, X_row);
        for (std::size_t link = 0; link < X_WL.size(); ++link) {
          EXPECT_TRUE(X_WL[link].isApprox(X_row[link], 1e-12)) << link;
        }
      }
    }
  }
}

TEST(JointMotion, AFloatingJointMovesAsARigidBodyDoes) {
  std::mt19937 random(5);
  const auto robot = RobotOf(Ball("a") + Ball("b") + JointText("fly", "floating", "a", "b", ""));
  const RobotModel& model = *robot->model;
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  for (int k = 0; k < 100; ++k) {
    const std::vector<double> from = RandomState(model, random);
    std::vector<double> to = RandomState(model, random);
    const auto pose = [](const std::vector<double>& v) {
      return MakePose({v[0], v[1], v[2]}, Quaternion(v[6], v[3], v[4], v[5]));
    };
    const RigidMotion rigid(Gripper(), pose(from), pose(to));
    const JointMotion motion(model, body, Pose::Identity(), from, to);
    const double fraction = std::uniform_real_distribution<double>(0, 1)(random);
    Pose X_WB;
    rigid.Place(fraction, {&X_WB, 1});
    std::vector<Pose> X_WL(2);
    motion.Place(fraction, X_WL);
    EXPECT_TRUE(X_WL[1].isApprox(X_WB, 1e-12));
    // Two quaternions stand for the same rotation; the sign must not change the path.
    for (std::size_t q = 3; q < 7; ++q) to[q] = -to[q];
    JointMotion(model, body, Pose::Identity(), from, to).Place(fraction, X_WL);
    EXPECT_TRUE(X_WL[1].isApprox(X_WB, 1e-12));
  }
}

TEST(JointMotion, APlanarJointGoesStraightAndTurnsTheShortWay) {
  const auto robot = RobotOf(Ball("a") + Ball("b") +
                             JointText("drive", "planar", "a", "b", "<axis xyz=\"0 0 1\"/>"));
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  const std::vector<double> from = {1, 2, 3}, to = {3, -2, -3};
  const JointMotion motion(*robot->model, body, Pose::Identity(), from, to);
  std::vector<Pose> X_WL(2);
  motion.Place(0.5, X_WL);
  EXPECT_TRUE(X_WL[1].translation().isApprox(Vector3(2, 0, 0), 1e-12));
  EXPECT_NEAR(X_WL[1].linear()(0, 0), -1, 1e-12);  // through pi, not 0
  // About its own origin, however far that is from the joint's.
  EXPECT_NEAR(motion.Travel_m(1),
              std::hypot(2, 4) + 0.1 * std::sqrt(3) * (2 * std::numbers::pi - 6), 1e-12);
}

TEST(JointMotion, TurnsContinuousJointsTheShortWay) {
  const auto robot = RobotOf(Ball("a") + Ball("b") +
                             JointText("roll", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/>"));
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  const JointMotion motion(*robot->model, body, Pose::Identity(), std::vector<double>{3.0},
                           std::vector<double>{-3.0});
  std::vector<Pose> X_WL(2);
  motion.Place(0.5, X_WL);
  EXPECT_NEAR(X_WL[1].linear()(0, 0), -1, 1e-12);  // through pi, not 0
}

// The mimic joint cannot pass pi, so no state on the short way is within its limits.
TEST(JointMotion, TurnsTheLongWayWhereAFollowerHasLimits) {
  const auto robot = RobotOf(Ball("a") + Ball("b") + Ball("c") +
                             JointText("roll", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/>") +
                             JointText("also", "revolute", "b", "c",
                                       "<axis xyz=\"0 0 1\"/><limit lower=\"-3.1\" upper=\"3.1\"/>"
                                       "<mimic joint=\"roll\"/>"));
  const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
  const JointMotion motion(*robot->model, body, Pose::Identity(), std::vector<double>{3.0},
                           std::vector<double>{-3.0});
  std::vector<Pose> X_WL(3);
  motion.Place(0.5, X_WL);
  EXPECT_NEAR(X_WL[1].linear()(0, 0), 1, 1e-12);  // through 0
}

TEST(JointMotion, EndsWhereItsRowIsWhateverFollowsAContinuousJoint) {
  for (const std::string kind : {"prismatic", "revolute"}) {
    const auto robot = RobotOf(Ball("a") + Ball("b") + Ball("c") +
                               JointText("roll", "continuous", "a", "b", "<axis xyz=\"0 0 1\"/>") +
                               JointText("also", kind, "b", "c",
                                         "<axis xyz=\"0 0 1\"/><limit lower=\"-9\" upper=\"9\"/>"
                                         "<mimic joint=\"roll\" multiplier=\"0.3\"/>"));
    const QueryBody body = BodyFromRobot(*robot, RobotScope::kBoth);
    const std::vector<double> from = {-3}, to = {3};
    const JointMotion motion(*robot->model, body, Pose::Identity(), from, to);
    std::vector<Pose> X_WL(3), X_to(3);
    motion.Place(1, X_WL);
    LinkPoses(*robot->model, Pose::Identity(), to, X_to);
    EXPECT_TRUE(X_WL[2].isApprox(X_to[2], 1e-12)) << kind;
  }
}

}  // namespace
}  // namespace cwm::collision
