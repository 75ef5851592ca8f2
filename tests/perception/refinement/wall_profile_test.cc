#include "perception/refinement/split/wall_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kSigma_m = 0.0008;

// A wall of 12 cm with a point every 3 mm and noise of the claimed sigma.
std::vector<ProfilePoint> Wall(const std::function<double(double)>& offset_m,
                               std::uint64_t seed = 1) {
  RandomDraws draws(seed, 0);
  std::vector<ProfilePoint> profile;
  for (int k = 0; k < 40; ++k) {
    const double along_m = 0.003 * k;
    profile.push_back({along_m, offset_m(along_m) + kSigma_m * draws.Normal(), kSigma_m});
  }
  return profile;
}

TEST(StraightPieces, AreTheWallsThatMadeThem) {
  const auto pieces =
      StraightPieces(Wall([](double s) { return s < 0.05 ? 0.03 : 0.04 + 0.2 * (s - 0.05); }));
  ASSERT_THAT(pieces, SizeIs(2));
  EXPECT_NEAR(pieces[0].end_m, 0.05, 0.004);
  EXPECT_NEAR(pieces[0].slope, 0, 4 * pieces[0].slope_sigma);
  EXPECT_NEAR(pieces[1].slope, 0.2, 4 * pieces[1].slope_sigma);
  EXPECT_NEAR(pieces[1].begin_offset_m, 0.04, 4 * pieces[1].sigma_m + 0.001);
}

TEST(SeamsOf, OneStraightWallAreNoneForHundredSeeds) {
  int seams = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    seams += static_cast<int>(SeamsOf(Wall([](double s) { return 0.03 + 0.1 * s; }, seed)).size());
  }
  EXPECT_LE(seams, 1);
}

TEST(SeamsOf, LieAtJumps) {
  const auto seams = SeamsOf(Wall([](double s) { return s < 0.06 ? 0.03 : 0.025; }));
  ASSERT_THAT(seams, SizeIs(1));
  EXPECT_NEAR(seams[0], 0.06, 0.003);
}

TEST(SeamsOf, LieInConcaveCreasesAndNotInConvexOnes) {
  const auto crease = [](double turn) {
    return [turn](double s) { return 0.03 + (s < 0.06 ? 0 : turn * (s - 0.06)); };
  };
  EXPECT_THAT(SeamsOf(Wall(crease(0.3))), SizeIs(1));
  EXPECT_THAT(SeamsOf(Wall(crease(-0.3))), IsEmpty());
}

TEST(SeamsOf, NothingAreNone) { EXPECT_THAT(SeamsOf({}), IsEmpty()); }

}  // namespace
}  // namespace cwm::perception
