#include "collision/inverse_kinematics/ik_steps.h"

#include <gtest/gtest.h>

#include <random>

#include "collision/robot/kinematics.h"
#include "tests/collision/inverse_kinematics/planar_arm.h"

namespace cwm::collision {
namespace {

using testing::ModelOf;
using testing::Planar;
using testing::PlanarArm;

IkChain ChainOf(const RobotModel& model, const char* link, const Pose& X_LT = Pose::Identity()) {
  auto chain = MakeIkChain(model, model.all, DefaultVariables(model), *model.FindLink(link), X_LT);
  EXPECT_TRUE(chain.ok()) << chain.status();
  return *std::move(chain);
}

TEST(IkSteps, MeasureTheErrorBeforeTheStep) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ChainOf(*model, "e");
  IkValues<double, 1> values = {};  // stretched: the tool is at (1.2, 0, 0)
  const IkErrors<double, 1> errors = StepIk(chain, IkTargetOf(Planar(1.2, 0.3, 0.1)), values);
  EXPECT_NEAR(errors.position2[0], 0.09, 1e-15);
  EXPECT_NEAR(errors.rotation2[0], 4 * std::pow(std::sin(0.05), 2), 1e-15);
}

TEST(IkSteps, HalfATurnIsTheLargestError) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ChainOf(*model, "e");
  IkValues<double, 1> values = {};
  const IkErrors<double, 1> errors =
      StepIk(chain, IkTargetOf(Planar(1.2, 0, std::numbers::pi)), values);
  EXPECT_NEAR(errors.rotation2[0], 4, 1e-12);
}

TEST(IkSteps, ConvergeQuadraticallyNearASolution) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ChainOf(*model, "e");
  IkValues<double, 1> values = {{0.01, 1.56, -0.01}};  // the solution is 0, pi / 2, 0
  const IkTarget<double> target = IkTargetOf(testing::WristAt(0.5, 0.5, std::numbers::pi / 2));
  double before = StepIk(chain, target, values).Total(0);
  for (int step = 0; step < 3; ++step) {
    const double now = StepIk(chain, target, values).Total(0);
    EXPECT_LE(now, std::max(1e-30, 10 * before * before)) << step;
    before = now;
  }
  EXPECT_LT(before, 1e-24);
}

TEST(IkSteps, InSinglePrecisionAreThoseInDoublePrecision) {
  const auto model = ModelOf(PlanarArm());
  const IkChain chain = ChainOf(*model, "e", MakeTranslation(0.1, 0.02, 0.03));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> angle(-3, 3);
  const Pose X_BT = Planar(0.4, 0.3, 1);
  IkValues<float, kIkStarts> lanes;
  std::vector<IkValues<double, 1>> each(kIkStarts);
  for (std::size_t k = 0; k < kIkStarts; ++k) {
    for (std::size_t v = 0; v < 3; ++v) {
      each[k].of[v] = angle(random);
      lanes.of[v * kIkStarts + k] = static_cast<float>(each[k].of[v]);
    }
  }
  const auto rounded = StepIkStarts(chain, RoundedIkTargetOf(X_BT), lanes);
  for (std::size_t k = 0; k < kIkStarts; ++k) {
    const auto exact = StepIk(chain, IkTargetOf(X_BT), each[k]);
    EXPECT_NEAR(rounded.position2[k], exact.position2[0], 1e-4);
    EXPECT_NEAR(rounded.rotation2[k], exact.rotation2[0], 1e-4);
    for (std::size_t v = 0; v < 3; ++v) {
      EXPECT_NEAR(lanes.of[v * kIkStarts + k], each[k].of[v], 2e-3) << k << " " << v;
    }
  }
}

TEST(IkSteps, StopAtLimitsAndMoveTheOthers) {
  const auto model = ModelOf(PlanarArm("0.5"));
  const IkChain chain = ChainOf(*model, "e");
  IkValues<double, 1> values = {{0.5, 0.5, 0}};
  // The pose would need the shoulder and the elbow to turn farther.
  const IkTarget<double> target = IkTargetOf(Planar(-0.2, 1.0, 2.5));
  for (int step = 0; step < 30; ++step) StepIk(chain, target, values);
  EXPECT_EQ(values.of[0], 0.5);
  EXPECT_EQ(values.of[1], 0.5);
  EXPECT_EQ(values.of[2], 0.5);
}

TEST(IkChain, RefusesWhatItCannotSolve) {
  const auto model = ModelOf(PlanarArm());
  const std::vector<double> base = DefaultVariables(*model);
  EXPECT_FALSE(MakeIkChain(*model, model->all, base, *model->FindLink("a"), Pose::Identity()).ok());
  const auto planar = ModelOf(
      testing::Robot(testing::Links("ab") + testing::JointText("j", "planar", "a", "b", "")));
  const auto chain = MakeIkChain(*planar, planar->all, DefaultVariables(*planar),
                                 *planar->FindLink("b"), Pose::Identity());
  ASSERT_FALSE(chain.ok());
  EXPECT_NE(chain.status().message().find("planar"), std::string::npos);
}

}  // namespace
}  // namespace cwm::collision
