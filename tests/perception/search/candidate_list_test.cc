#include "perception/search/candidate_list.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/perception/search/exact_points.h"

namespace cwm::perception {
namespace {

PlaneModel PlaneAtHeight(double z_m, const ModelPoints& points) {
  return {.point = Vector3(0, 0, z_m) - points.origin_L, .normal = Vector3::UnitZ()};
}

TEST(CandidateList, BoundsAScoreFromTheFirstSubset) {
  ExactPoints exact;
  exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 30, 30);
  exact.AddGrid(Vector3(0, 0, 0.05), Vector3::UnitZ(), 30, 30);
  const ModelPoints points = exact.Model();
  const Connectivity connectivity(points);
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    CandidateList list(points, connectivity, seed);
    list.Add(PlaneAtHeight(0, points));
    ASSERT_EQ(list.candidates().size(), 1u);
    EXPECT_EQ(list.candidates()[0].subsets_done, 1u);
    held += list.candidates()[0].bound >= 900 ? 1 : 0;
    // The share of one half among 128 points scatters by 0.044, and the bound adds 2.5 times as
    // much.
    EXPECT_LT(list.candidates()[0].bound, 1500);
    EXPECT_NEAR(list.Leader()->bound, 900, 1e-6);
  }
  EXPECT_GE(held, 36);  // 99 % of them should
}

TEST(CandidateList, ScoresTheLargerPieceOfWhatFellApartByItsSquaredDistances) {
  ExactPoints strip;
  strip.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 90, 20);
  const ModelPoints points = strip.Model();
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  list.Add(PlaneAtHeight(0.0015, points));  // half the gate away from all points
  ASSERT_EQ(list.Leader()->inliers.size(), 1800u);
  EXPECT_NEAR(list.Leader()->score, 1800 * 0.75, 0.01);
  const auto x_m = [&points](std::uint32_t i) { return points.p[i].x() + points.origin_L.x(); };
  std::vector<std::uint32_t> taken;  // columns 30 to 49, from x = -43.5 to 13.5 mm
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (x_m(i) > -0.045 && x_m(i) < 0.015) taken.push_back(i);
  }
  ASSERT_EQ(taken.size(), 400u);
  list.Remove(taken);
  EXPECT_EQ(list.available_count(), 1400u);
  const Candidate* leader = list.Leader();
  ASSERT_NE(leader, nullptr);
  EXPECT_EQ(leader->inliers.size(), 800u);
  EXPECT_NEAR(leader->score, 800 * 0.75, 0.01);
  for (std::uint32_t i : leader->inliers) EXPECT_GT(x_m(i), 0.015);
}

TEST(CandidateList, RefusesOneKindOnOnePlaceAlone) {
  ExactPoints exact;
  exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 30, 30);
  exact.AddGrid(Vector3(0, 0, 0.2), Vector3::UnitZ(), 10, 10);
  const ModelPoints points = exact.Model();
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  list.Add(PlaneAtHeight(0, points));
  list.Add(PlaneAtHeight(0.2, points));
  // The sphere touches the middle of the large square, whose corners lie 1.9 mm away from it.
  list.Add(SphereModel{.center = Vector3(0, 0, -1) - points.origin_L, .radius_m = 1});
  const Candidate leader = *list.Leader();
  ASSERT_TRUE(IsPlane(leader.model));
  ASSERT_EQ(leader.inliers.size(), 900u);
  list.Reject(leader);
  list.Add(PlaneAtHeight(0.0005, points));
  ASSERT_EQ(list.candidates().size(), 2u);
  const Candidate* next = list.Leader();
  ASSERT_NE(next, nullptr);
  EXPECT_TRUE(std::holds_alternative<SphereModel>(next->model));
  EXPECT_EQ(next->inliers.size(), 900u);
  EXPECT_EQ(list.available_count(), points.size());  // rejected, not taken
}

TEST(CandidateList, HasNoLeaderWithoutInliers) {
  ExactPoints exact;
  exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 20, 20);
  const ModelPoints points = exact.Model();
  const Connectivity connectivity(points);
  CandidateList list(points, connectivity, 1);
  EXPECT_EQ(list.Leader(), nullptr);
  list.Add(PlaneAtHeight(1, points));
  EXPECT_TRUE(list.candidates().empty());
  list.Add(PlaneAtHeight(0, points));
  const std::vector<std::uint32_t> all = list.Leader()->inliers;
  list.Remove(all);
  EXPECT_EQ(list.available_count(), 0u);
  EXPECT_EQ(list.Leader(), nullptr);
}

}  // namespace
}  // namespace cwm::perception
