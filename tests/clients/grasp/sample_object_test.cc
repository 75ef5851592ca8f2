#include "clients/grasp/sample_object.h"

#include <gtest/gtest.h>

namespace cwm::grasp {
namespace {

cwm::v1::Object BallAt(double x_m, double z_m) {
  cwm::v1::Object object;
  object.mutable_x_world_object()->set_tx_m(x_m);
  object.mutable_x_world_object()->set_qw(1);
  cwm::v1::ShapePart& part = *object.add_shapes();
  part.mutable_x_object_shape()->set_tz_m(z_m);
  part.mutable_x_object_shape()->set_qw(1);
  part.mutable_sphere()->set_radius_m(0.02);
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
  cwm::v1::Object ball = BallAt(0, 0);
  for (const double sigma : {0.001, 0.001, 0.001, 0.0005}) {
    ball.mutable_shapes(0)->mutable_fit()->add_parameter_sigma(sigma);
  }
  EXPECT_DOUBLE_EQ(SampleObject(ball, {}).list.front().sigma_m, 0.001);
}

TEST(SampleObject, EdgesOfWhichNoEndWasSeenAreGuesses) {
  cwm::v1::Object object;
  cwm::v1::ShapePart& part = *object.add_shapes();
  part.mutable_box()->set_size_x_m(0.05);
  part.mutable_box()->set_size_y_m(1);
  part.mutable_box()->set_size_z_m(1);
  for (const double sigma : {0.0, 0.001, 0.001}) part.mutable_fit()->add_parameter_sigma(sigma);
  EXPECT_DOUBLE_EQ(SampleObject(object, {}).list.front().sigma_m, 0.01);
}

TEST(SampleObject, NothingKnownMakesNoCandidates) {
  const Candidates none = SampleObject(cwm::v1::Object(), {});
  EXPECT_TRUE(none.list.empty());
  EXPECT_LT(none.min_width_m, 0);
}

}  // namespace
}  // namespace cwm::grasp
