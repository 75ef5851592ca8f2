#include "collision/spheres/revolute_pair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace cwm::collision {
namespace {

// The tolerance of KeepsApart, and the number of sampled angles.
constexpr double kMissed_m = 1e-3;
constexpr int kTurns = 400;

struct Chain {
  RevoluteJoint near, far;
  Vector3 p_A, p_B;

  Vector3 FromAToB(double near_rad, double far_rad) const {
    const auto turned = [](const RevoluteJoint& joint, double turn_rad) {
      return Pose(joint.X_PF * Eigen::AngleAxisd(turn_rad, Vector3::UnitZ()));
    };
    return turned(near, near_rad) * (turned(far, far_rad) * p_B) - p_A;
  }

  // The least distance over many states, with the far joint all the way around.
  double Sampled_m() const {
    double min_m = std::numeric_limits<double>::infinity();
    for (int i = 0; i <= kTurns; ++i) {
      const double near_rad =
          near.lower_rad + (near.upper_rad - near.lower_rad) * i / double{kTurns};
      for (int j = 0; j < kTurns; ++j) {
        const double far_rad = 2 * std::numbers::pi * j / kTurns;
        min_m = std::min(min_m, FromAToB(near_rad, far_rad).norm());
      }
    }
    return min_m;
  }
  // A bound on the distance of a state from the nearest sampled one: half a step of each joint.
  double SampledApart_m() const {
    const double reach_B_m = far.X_PF.translation().norm() + p_B.norm();
    const double step = (near.upper_rad - near.lower_rad + 2 * std::numbers::pi) / kTurns / 2;
    return step * reach_B_m;
  }
};

class TurningPairTest : public ::testing::Test {
 protected:
  double Between(double lower, double upper) {
    return std::uniform_real_distribution<>(lower, upper)(random_);
  }
  Vector3 Point() { return {Between(-0.2, 0.2), Between(-0.2, 0.2), Between(-0.2, 0.2)}; }
  RevoluteJoint Joint() {
    RevoluteJoint joint;
    const Quaternion turn(Between(-1, 1), Between(-1, 1), Between(-1, 1), Between(-1, 1));
    joint.X_PF.linear() = turn.normalized().toRotationMatrix();
    joint.X_PF.translation() = Point();
    joint.lower_rad = Between(-3, 0);
    joint.upper_rad = Between(0, 3);
    return joint;
  }
  Chain AnyChain() { return {Joint(), Joint(), Point(), Point()}; }

  std::mt19937_64 random_{7};
};

TEST_F(TurningPairTest, KeepsNoPairApartThatAStateBringsTogether) {
  for (int k = 0; k < 50; ++k) {
    const Chain chain = AnyChain();
    const double sampled_m = chain.Sampled_m();
    const RevolutePair pair(chain.near, chain.far);
    EXPECT_FALSE(pair.KeepsApart(chain.p_A, chain.p_B, 1.0001 * sampled_m)) << k;
  }
}

TEST_F(TurningPairTest, KeepsApartWhatIsFartherByAMillimetre) {
  for (int k = 0; k < 50; ++k) {
    const Chain chain = AnyChain();
    const double apart_m = chain.Sampled_m() - chain.SampledApart_m() - 1.01 * kMissed_m;
    const RevolutePair pair(chain.near, chain.far);
    EXPECT_TRUE(pair.KeepsApart(chain.p_A, chain.p_B, apart_m)) << k;
  }
}

TEST_F(TurningPairTest, KnowsTheLimitsOfTheNearJoint) {
  // Two arms of 0.2 m on parallel axes 0.5 m apart, with the near one turned away.
  RevoluteJoint near, far;
  far.X_PF.translation().x() = 0.5;
  const Vector3 p_A(-0.2, 0, 0), p_B(0.2, 0, 0);
  near.lower_rad = -0.5, near.upper_rad = 0.5;
  EXPECT_TRUE(RevolutePair(near, far).KeepsApart(p_A, p_B, 0.4));
  near.upper_rad = std::numbers::pi;
  EXPECT_FALSE(RevolutePair(near, far).KeepsApart(p_A, p_B, 0.4));
  EXPECT_TRUE(RevolutePair(near, far).KeepsApart(p_A, p_B, 0.099 - kMissed_m));
  EXPECT_FALSE(RevolutePair(near, far).KeepsApart(p_A, p_B, 0.101));
}

TEST_F(TurningPairTest, OfOneJointIsACircleAndAPoint) {
  RevoluteJoint only;
  only.X_PF.translation().z() = 0.3;
  const RevolutePair pair(only);
  const Vector3 p_A(0.5, 0, 0), p_B(0, 0.1, 0);
  const double apart_m = std::hypot(0.4, 0.3);
  EXPECT_TRUE(pair.KeepsApart(p_A, p_B, 0.99 * apart_m));
  EXPECT_FALSE(pair.KeepsApart(p_A, p_B, 1.01 * apart_m));
}

TEST_F(TurningPairTest, IsSureOfNothingAboutWhatIsNoNumber) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(RevolutePair(Joint(), Joint()).KeepsApart(Vector3(none, 0, 0), Point(), 0.1));
}

}  // namespace
}  // namespace cwm::collision
