#include "perception/search/shape_search.h"

#include <gtest/gtest.h>

#include "perception/cloud/tolerances.h"
#include "tests/perception/search/exact_points.h"

namespace cwm::perception {
namespace {

// Adds 30 x 30 points at z = 0.
void AddSquareTo(ExactPoints& exact) { exact.AddGrid(Vector3(0, 0, 0), Vector3::UnitZ(), 30, 30); }

// Adds the upper part of a ball beside the square and above it.
void AddBallTo(ExactPoints& exact) {
  exact.AddCap({.center = Vector3(0.3, 0, 0.05), .radius_m = 0.05}, 60 * kDegree, 400);
}

// A search with all of its input.
struct SearchOf {
  SearchOf(const ExactPoints& exact, const ModelerOptions& wanted)
      : points(exact.Model()),
        octree(points),
        connectivity(points),
        candidates(points, connectivity, wanted.seed),
        options(wanted),
        search(points, octree, candidates, options, kSerialWork) {}

  ModelPoints points;
  Octree octree;
  Connectivity connectivity;
  CandidateList candidates;
  ModelerOptions options;
  ShapeSearch search;
};

TEST(ShapeSearch, FindsOneShapeAfterTheOtherUntilNoneIsLeft) {
  ExactPoints exact;
  AddSquareTo(exact);
  AddBallTo(exact);
  SearchOf of(exact, {});
  const auto first = of.search.Next();
  ASSERT_TRUE(first);
  EXPECT_TRUE(IsPlane(first->model));
  EXPECT_EQ(first->inliers.size(), 900u);
  of.candidates.Remove(first->inliers);
  const auto second = of.search.Next();
  ASSERT_TRUE(second);
  const auto* ball = std::get_if<SphereModel>(&second->model);
  ASSERT_NE(ball, nullptr);
  EXPECT_NEAR(ball->radius_m, 0.05, 1e-4);
  EXPECT_NEAR((ball->center + of.points.origin_L - Vector3(0.3, 0, 0.05)).norm(), 0, 1e-4);
  EXPECT_EQ(second->inliers.size(), 400u);
  of.candidates.Remove(second->inliers);
  EXPECT_FALSE(of.search.Next());
  EXPECT_FALSE(of.search.is_exhausted());
}

TEST(ShapeSearch, ProposesNoKindThatIsOffAndNoRadiusBeyondItsLimits) {
  ExactPoints square, ball;
  AddSquareTo(square);
  AddBallTo(ball);
  EXPECT_TRUE(SearchOf(square, {}).search.Next());
  EXPECT_FALSE(SearchOf(square, {.search_planes = false}).search.Next());
  ModelerOptions balls;
  balls.search_planes = balls.search_cylinders = balls.search_cones = false;
  EXPECT_TRUE(SearchOf(ball, balls).search.Next());
  balls.max_radius_m = 0.04;
  EXPECT_FALSE(SearchOf(ball, balls).search.Next());
  balls.max_radius_m = 0.5;
  balls.min_radius_m = 0.06;
  EXPECT_FALSE(SearchOf(ball, balls).search.Next());
}

TEST(ShapeSearch, LooksForNothingSmallerThanAShapeMustBe) {
  ExactPoints exact;
  AddSquareTo(exact);
  AddBallTo(exact);
  EXPECT_TRUE(SearchOf(exact, {.min_inliers = 900}).search.Next());
  SearchOf in_vain(exact, {.min_inliers = 901});
  EXPECT_FALSE(in_vain.search.Next());
  EXPECT_FALSE(in_vain.search.is_exhausted());
}

// No amount of work makes the probability to miss a shape zero.
TEST(ShapeSearch, TellsWhenTheWorkRanOutFirst) {
  ExactPoints square;
  AddSquareTo(square);
  SearchOf of(square, {.search_planes = false, .missed_shape_probability = 0});
  EXPECT_FALSE(of.search.Next());
  EXPECT_TRUE(of.search.is_exhausted());
}

}  // namespace
}  // namespace cwm::perception
