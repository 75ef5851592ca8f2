// Robots of spheres in SIMD lanes must give the verdicts of the plain path, state by state.
#include "collision/query/sphere_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <array>
#include <cmath>
#include <iomanip>
#include <numbers>
#include <random>
#include <set>
#include <sstream>
#include <string>

#include "collision/robot/kinematics.h"
#include "collision/robot/urdf.h"
#include "tests/collision/query/plain_rows.h"
#include "tests/collision/query/room_of_all_kinds.h"
#include "tests/collision/query/sphere_arm.h"
#include "tests/collision/robot/robot_text.h"

namespace cwm::collision {
namespace {

using testing::JointText;
using testing::Links;

std::vector<double> RandomRows(const JointGroup& group, std::size_t count, std::mt19937& random) {
  std::vector<double> rows;
  for (std::size_t k = 0; k < count * group.variables.size(); ++k) {
    rows.push_back(std::uniform_real_distribution<double>(-2.5, 2.5)(random));
    if (k % group.variables.size() == 0) rows.back() *= 0.15;  // the rail: some beyond its limits
    if (k % group.variables.size() == 1) rows.back() *= 4;     // more than a turn
  }
  return rows;
}

// Counts the verdicts, on which all variants must agree.
std::array<std::size_t, 5> ExpectPlainVerdicts(const WorldSnapshot& world, const QueryBody& body,
                                               const JointRows& rows, QueryOptions options) {
  EXPECT_TRUE(SphereCheck::Make(world, body, rows, options).has_value());
  const CollisionColumns plain = *CheckCollisions(world, body, PlainRows(rows), options);
  options.naming = Naming::kWhereTested;
  const CollisionColumns in_lanes = *CheckCollisions(world, body, rows, options);
  std::array<std::size_t, 5> counts{};
  std::size_t mismatches = 0;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    mismatches += plain.verdict[k] != in_lanes.verdict[k] ? 1 : 0;
    ++counts[static_cast<std::size_t>(plain.verdict[k])];
  }
  EXPECT_EQ(mismatches, 0u) << LaneTarget();
  EXPECT_EQ(in_lanes.completed, rows.size());
  return counts;
}

class SphereCheckTest : public ::testing::Test {
 protected:
  // Tests states around those at which the world is just touched, found by bisection.
  void ExpectPlainVerdictsAtContact(const WorldSnapshot& world) {
    const std::size_t width = model_->all.variables.size();
    std::vector<double> rows;
    const std::vector<double> random_rows = RandomRows(model_->all, 3000, random_);
    const CollisionColumns columns = *CheckCollisions(world, body_, Rows(random_rows), {});
    for (std::size_t k = 0; k + 1 < 3000; ++k) {
      if (columns.verdict[k] != Verdict::kFree || columns.verdict[k + 1] != Verdict::kCollision)
        continue;
      const Eigen::Map<const Eigen::VectorXd> free(&random_rows[k * width],
                                                   static_cast<Eigen::Index>(width));
      const Eigen::Map<const Eigen::VectorXd> hit(&random_rows[(k + 1) * width],
                                                  static_cast<Eigen::Index>(width));
      double low = 0, high = 1;
      for (int step = 0; step < 40; ++step) {
        const double middle = 0.5 * (low + high);
        const Eigen::VectorXd state = free + middle * (hit - free);
        const Verdict verdict =
            CheckCollisions(world, body_, PlainRows(Rows({state.data(), width})), {})->verdict[0];
        (verdict == Verdict::kFree ? low : high) = middle;
      }
      for (double off : {-1e-7, -1e-8, -1e-9, 0.0, 1e-9, 1e-8, 1e-7}) {
        const Eigen::VectorXd state = free + (low + off) * (hit - free);
        rows.insert(rows.end(), state.begin(), state.end());
      }
    }
    ASSERT_GT(rows.size(), 1000u * width);
    const auto counts = ExpectPlainVerdicts(world, body_, Rows(rows), {});
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kFree)], 300u);
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kCollision)], 300u);
  }

  JointRows Rows(std::span<const double> rows) const {
    return {*model_, model_->all, {.X_WB = X_WB_, .base = DefaultVariables(*model_), .rows = rows}};
  }

  std::shared_ptr<const RobotModel> model_ = SphereArm();
  QueryBody body_ = BodyOfSphereArm(*model_);
  Pose X_WB_ =
      MakePose({0.2, -0.3, 0.1}, Quaternion(Eigen::AngleAxisd(0.8, Vector3(1, 2, 3).normalized())));
  std::mt19937 random_{7};
};

TEST_F(SphereCheckTest, HasThePlainVerdictsAmongAllKindsOfShapes) {
  const auto world = WorldOf(RoomOfAllKinds(random_));
  const std::vector<double> rows = RandomRows(model_->all, 4000, random_);
  for (double margin_m : {0.0, 0.02}) {
    const auto counts = ExpectPlainVerdicts(*world, body_, Rows(rows), {.margin_m = margin_m});
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kCollision)], 100u);
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kOutOfLimits)], 100u);
  }
}

TEST_F(SphereCheckTest, HasTheSameVerdictsOnAnyNumberOfThreads) {
  const auto world = WorldOf(RoomOfAllKinds(random_));
  const std::vector<double> rows = RandomRows(model_->all, 5000, random_);
  for (const Naming naming : {Naming::kEachRow, Naming::kWhereTested}) {
    QueryOptions options{.naming = naming};
    const CollisionColumns alone = *CheckCollisions(*world, body_, Rows(rows), options);
    for (const int threads : {2, 4}) {
      options.threads = threads;
      const CollisionColumns together = *CheckCollisions(*world, body_, Rows(rows), options);
      EXPECT_EQ(together.completed, rows.size() / model_->all.variables.size());
      EXPECT_EQ(together.verdict, alone.verdict);
      EXPECT_EQ(together.object, alone.object);
      EXPECT_EQ(together.body_part, alone.body_part);
      EXPECT_EQ(together.object_part, alone.object_part);
      EXPECT_EQ(together.accuracy, alone.accuracy);
    }
  }
}

// Boxes, cylinders, balls and capsules in all directions and on level ground; one has a margin of
// its own, and one is larger than the arm's reach.
std::vector<Change> Solids(std::mt19937& random) {
  std::vector<Change> changes;
  const std::vector<Shape> kinds = {Box{{0.1, 0.2, 0.05}}, Cylinder{0.06, 0.2}, Sphere{0.07},
                                    Capsule{0.05, 0.3}};
  for (int k = 0; k < 16; ++k) {
    Pose X_WO = RandomPose(random, 0.9);
    if (k >= 8) X_WO.linear().setIdentity();
    changes.push_back(
        PutOf("solid" + std::to_string(k),
              {{.X_FS = Pose::Identity(), .shape = kinds[static_cast<std::size_t>(k) % 4]}}, X_WO));
    if (k == 3) std::get<PutObject>(changes.back().what).margin_m = 0.03;
  }
  changes.push_back(PutOf("floor", {{.X_FS = Pose::Identity(), .shape = Box{{80, 60, 0.1}}}},
                          MakeTranslation(20, 10, -0.9)));
  return changes;
}

TEST_F(SphereCheckTest, HasThePlainVerdictsOfAHundredThousandStatesOnEveryInstructionSet) {
  const auto world = WorldOf(Solids(random_));
  const std::vector<double> rows = RandomRows(model_->all, 100000, random_);
  const auto counts = ExpectPlainVerdicts(*world, body_, Rows(rows), {});
  for (Verdict verdict : {Verdict::kFree, Verdict::kCollision, Verdict::kOutOfLimits}) {
    EXPECT_GT(counts[static_cast<std::size_t>(verdict)], 5000u);
  }
  const std::span<const double> few = std::span(rows).first(10000 * model_->all.variables.size());
  std::set<std::string> tested;
  for (std::int64_t targets = hwy::SupportedTargets(); targets != 0; targets &= targets - 1) {
    hwy::SetSupportedTargetsForTest(targets & -targets);
    tested.insert(LaneTarget());
    ExpectPlainVerdicts(*world, body_, Rows(few), {});
  }
  hwy::SetSupportedTargetsForTest(0);
  const auto answers = [&](std::int64_t target) {
    return (hwy::SupportedTargets() & target) == 0 || tested.contains(hwy::TargetName(target));
  };
  EXPECT_TRUE(answers(HWY_SSE4) && answers(HWY_AVX2) && answers(HWY_AVX3));
}

// A rotation by any number of quarter turns about each axis.
Quaternion Quarters(std::mt19937& random) {
  Quaternion turned = Quaternion::Identity();
  for (int axis = 0; axis < 3; ++axis) {
    const int quarters = std::uniform_int_distribution<int>(0, 3)(random);
    turned = turned *
             Quaternion(Eigen::AngleAxisd(quarters * std::numbers::pi / 2, Vector3::Unit(axis)));
  }
  return turned;
}

// The same kinds, most at right angles to each other but not to the arm, on an infinite floor.
std::vector<Change> Shelves(std::mt19937& random) {
  const Quaternion askew(Eigen::AngleAxisd(0.6, Vector3::UnitZ()));
  const std::vector<Shape> kinds = {Box{{0.1, 0.2, 0.05}}, Cylinder{0.06, 0.2},
                                    Box{{0.3, 0.1, 0.2}}, Capsule{0.05, 0.3}};
  std::vector<Change> changes;
  for (int k = 0; k < 24; ++k) {
    const Vector3 at = RandomPose(random, 0.9).translation();
    const Quaternion turned =
        k < 20 ? askew * Quarters(random) : Quaternion(RandomPose(random, 1).linear());
    changes.push_back(
        PutOf("solid" + std::to_string(k),
              {{.X_FS = Pose::Identity(), .shape = kinds[static_cast<std::size_t>(k) % 4]}},
              MakePose(at, turned)));
  }
  changes.push_back(PutOf("floor", {{.X_FS = Pose::Identity(), .shape = HalfSpace{}}},
                          MakePose({300, -200, -0.5}, askew)));
  return changes;
}

TEST_F(SphereCheckTest, HasThePlainVerdictsAmongShelvesAskewAndUpright) {
  const auto world = WorldOf(Shelves(random_));
  const std::vector<double> rows = RandomRows(model_->all, 20000, random_);
  for (const Pose& X_WB : {X_WB_, MakeTranslation(0.1, 0, 0)}) {
    X_WB_ = X_WB;
    const auto counts = ExpectPlainVerdicts(*world, body_, Rows(rows), {});
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kFree)], 500u);
    EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kCollision)], 1000u);
    ExpectPlainVerdictsAtContact(*world);
  }
}

TEST_F(SphereCheckTest, HasThePlainVerdictsWithinAMicrometreOfContact) {
  ExpectPlainVerdictsAtContact(*WorldOf(Solids(random_)));
}

// An arm whose joints are at right angles to each other, as in most robots, in one of the 24
// orientations each, with prismatic joints in between.
std::shared_ptr<const RobotModel> StraightArm(std::mt19937& random) {
  const std::string names = "abcdefgh";
  std::string joints;
  for (std::size_t k = 0; k + 1 < names.size(); ++k) {
    const auto quarters = [&] { return std::uniform_int_distribution<int>(-1, 2)(random); };
    std::ostringstream place;
    place << std::setprecision(17) << "<origin xyz=\"" << 0.1 * quarters() << " "
          << 0.1 * quarters() << " 0.15\" rpy=\"" << quarters() * std::numbers::pi / 2 << " "
          << quarters() * std::numbers::pi / 2 << " " << quarters() * std::numbers::pi / 2
          << "\"/><axis xyz=\"" << (k % 2 == 0 ? "0 0 1" : "0 -1 0")
          << "\"/><limit lower=\"-0.8\" upper=\"2.9\"/>";
    joints += JointText("joint" + std::to_string(k), k % 3 == 0 ? "prismatic" : "revolute",
                        names.substr(k, 1), names.substr(k + 1, 1), place.str());
  }
  return ModelOf(Links(names) + joints);
}

TEST_F(SphereCheckTest, HasThePlainVerdictsOfJointsAtRightAngles) {
  const auto world = WorldOf(Solids(random_));
  std::array<std::size_t, 5> counts{};
  for (int arm = 0; arm < 24; ++arm) {
    model_ = StraightArm(random_);
    body_ = BodyOfSphereArm(*model_);
    std::vector<double> rows;
    for (std::size_t k = 0; k < 600 * model_->all.variables.size(); ++k) {
      rows.push_back(std::uniform_real_distribution<double>(-0.9, 1.5)(random_));
    }
    const auto of_arm = ExpectPlainVerdicts(*world, body_, Rows(rows), {});
    for (std::size_t k = 0; k < counts.size(); ++k) counts[k] += of_arm[k];
  }
  EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kFree)], 200u);
  EXPECT_GT(counts[static_cast<std::size_t>(Verdict::kCollision)], 2000u);
}

TEST_F(SphereCheckTest, NamesThePlainPairsWhereEachRowIsNamed) {
  const auto world = WorldOf(Solids(random_));
  const std::vector<double> rows = RandomRows(model_->all, 2000, random_);
  const JointRows joint_rows = Rows(rows);
  const CollisionColumns plain = *CheckCollisions(*world, body_, PlainRows(joint_rows), {});
  const CollisionColumns named = *CheckCollisions(*world, body_, joint_rows, {});
  EXPECT_EQ(named.object, plain.object);
  EXPECT_EQ(named.body_part, plain.body_part);
  EXPECT_EQ(named.object_part, plain.object_part);
}

TEST_F(SphereCheckTest, LeavesOtherQuestionsToThePlainPath) {
  const auto world = WorldOf(Solids(random_));
  const std::vector<double> rows = RandomRows(model_->all, 10, random_);
  const JointRows joint_rows = Rows(rows);
  EXPECT_FALSE(SphereCheck::Make(*world, body_, PlainRows(joint_rows), {}).has_value());
  EXPECT_FALSE(
      SphereCheck::Make(*world, body_, joint_rows, {.engine = EngineChoice::kFcl}).has_value());
}

// Spheres do not tell how deep an overlap is, so that they prove gaps only.
TEST_F(SphereCheckTest, HasThePlainVerdictsWithANegativeMargin) {
  const auto world = WorldOf(Solids(random_));
  const std::vector<double> rows = RandomRows(model_->all, 2000, random_);
  ExpectPlainVerdicts(*world, body_, Rows(rows), {.margin_m = -0.01});
}

TEST(LaneSines, AreAsNearAsTheErrorsOfCentresTake) {
  std::vector<float> angles;
  std::vector<double> exact;
  for (int k = -2000000; k <= 2000000; ++k) {
    exact.push_back(std::numbers::pi * k / 2000000);
    angles.push_back(static_cast<float>(exact.back()));
  }
  std::vector<float> sines(angles.size()), cosines(angles.size());
  LaneSines(angles.data(), angles.size(), sines.data(), cosines.data());
  double worst = 0;
  for (std::size_t k = 0; k < angles.size(); ++k) {
    worst = std::max({worst, std::abs(sines[k] - std::sin(exact[k])),
                      std::abs(cosines[k] - std::cos(exact[k]))});
  }
  EXPECT_LT(worst, kSineError);
  EXPECT_GT(worst, 0.2 * kSineError);
}

}  // namespace
}  // namespace cwm::collision
