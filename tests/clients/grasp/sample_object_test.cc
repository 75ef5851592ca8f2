#include "clients/grasp/sample_object.h"

#include <gtest/gtest.h>

namespace cwm::grasp {
namespace {

Object BallAt(double x_m, double z_m) {
  Object object;
  object.X_WO.translation().x() = x_m;
  Part& part = object.parts.emplace_back();
  part.shape = Sphere{0.02};
  part.X_OS.translation().z() = z_m;
  return object;
}

TEST(SampleObject, CandidatesAreInTheWorld) {
  const Candidates found = SampleObject(BallAt(0.5, 0.1), {});
  ASSERT_FALSE(found.list.empty());
  for (const Candidate& candidate : found.list) {
    const Eigen::Vector3d middle = candidate.X_FG * Eigen::Vector3d(0, 0, candidate.retraction_m);
    EXPECT_NEAR((middle - Eigen::Vector3d(0.5, 0, 0.1)).norm(), 0, 1e-12);
  }
}

TEST(SampleObject, SigmaOfTheWidthIsTwiceThatOfTheRadius) {
  Object ball = BallAt(0, 0);
  ball.parts[0].fit = FitQuality{.parameter_sigma = {0.001, 0.001, 0.001, 0.0005}};
  EXPECT_DOUBLE_EQ(SampleObject(ball, {}).list.front().sigma_m, 0.001);
}

TEST(SampleObject, EdgesOfWhichNoEndWasSeenAreGuesses) {
  Object object;
  object.parts = {
      {.shape = Box{0.05, 1, 1}, .fit = FitQuality{.parameter_sigma = {0.0, 0.001, 0.001}}}};
  EXPECT_DOUBLE_EQ(SampleObject(object, {}).list.front().sigma_m, 0.01);
}

TEST(SampleObject, NothingKnownMakesNoCandidates) {
  const Candidates none = SampleObject(Object(), {});
  EXPECT_TRUE(none.list.empty());
  EXPECT_LT(none.min_width_m, 0);
}

}  // namespace
}  // namespace cwm::grasp
