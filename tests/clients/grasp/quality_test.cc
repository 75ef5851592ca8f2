#include "clients/grasp/quality.h"

#include <gtest/gtest.h>

#include <array>

namespace cwm::grasp {
namespace {

// A box of 4 cm held across x in its middle, from above.
struct HeldBox {
  Candidate candidate{.width_m = 0.04};
  Assessment assessment{.clearance_m = 0.02, .width_m = 0.04};
  Object object{};
  GraspQuery query{};

  HeldBox() {
    candidate.X_FG.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
    assessment.contacts[0].normal_W = -Eigen::Vector3d::UnitX();
    assessment.contacts[1].normal_W = Eigen::Vector3d::UnitX();
    object.owner = Owner::kPerception;
    Part part;
    part.shape = Box{.size_x_m = 0.04, .size_y_m = 0.04, .size_z_m = 0.04};
    part.fit = FitQuality{.observed_fraction = 0.6};
    object.parts.push_back(part);
  }

  Factors factors() const { return FactorsOf(candidate, assessment, object, query); }
};

TEST(Quality, CountsTheObservedShareOfTheWorseContact) {
  HeldBox held;
  EXPECT_DOUBLE_EQ(held.factors().observed, 0.6);
  held.object.parts.push_back(held.object.parts.front());
  held.object.parts.back().fit->observed_fraction = 0.3;
  held.assessment.contacts[1].part = 1;
  EXPECT_DOUBLE_EQ(held.factors().observed, 0.3);
  held.object.parts.back().role = PartRole::kCompleted;
  EXPECT_LT(held.factors().observed, 0.3);
}

// A board that was seen from the front, close to a wall that was not: behind it may be anything.
TEST(Quality, RanksAHoldBehindWhichNothingWasSeenLast) {
  HeldBox held;
  held.object.parts.front().fit->observed_fraction = 1;
  const Factors seen = held.factors();
  held.assessment.contacts[0].trust = Trust::kBounded;
  const Factors hidden = held.factors();
  EXPECT_DOUBLE_EQ(seen.observed, 1);
  EXPECT_LT(hidden.observed, 0.5);
  EXPECT_LT(ScoreOf(hidden), 0.8 * ScoreOf(seen));
}

TEST(Quality, TakesOneSideOfAnOpenSurfaceOfAScanForUnseen) {
  HeldBox held;
  held.object.parts.clear();  // a mesh of measured points
  for (Contact& contact : held.assessment.contacts) contact.trust = Trust::kSurfaceOnly;
  const double of_scan = held.factors().observed;
  held.assessment.contacts[1].trust = Trust::kExact;
  EXPECT_LT(of_scan, held.factors().observed) << "two surfaces face each other";
  held.assessment.contacts[1].trust = Trust::kSurfaceOnly;
  held.object.owner = Owner::kUser;
  EXPECT_DOUBLE_EQ(held.factors().observed, 1) << "what users put is known";
}

}  // namespace
}  // namespace cwm::grasp
