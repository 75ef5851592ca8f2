// The boxes around the points of movers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "perception/live/mover_pieces.h"
#include "perception/simulation/random_draws.h"

namespace cwm::perception {
namespace {

using Points = std::vector<Eigen::Vector3f>;

// The half of a vertical cylinder that faces +x.
Points HalfCylinder(double radius_m, double length_m, double spacing_m) {
  Points points;
  for (double z = 0; z <= length_m; z += spacing_m) {
    for (double angle = -std::numbers::pi / 2; angle <= std::numbers::pi / 2;
         angle += spacing_m / radius_m) {
      points.push_back(
          Vector3(radius_m * std::cos(angle), radius_m * std::sin(angle), z).cast<float>());
    }
  }
  return points;
}

double DistanceTo(const std::vector<MoverPiece>& pieces, const Vector3& p_W) {
  double least_m = 1e9;
  for (const MoverPiece& piece : pieces) {
    for (const Aabb& box : piece.boxes_W) least_m = std::min(least_m, box.exteriorDistance(p_W));
  }
  return least_m;
}

std::size_t BoxCount(const std::vector<MoverPiece>& pieces) {
  std::size_t count = 0;
  for (const MoverPiece& piece : pieces) count += piece.boxes_W.size();
  return count;
}

// An arm of 8 cm and a ball-like fist, far from the world's origin.
TEST(MoverPieces, CoverEveryPointWithoutMuchMore) {
  const Vector3 origin_W(120, -40, 3);
  const std::vector<Points> lists = {HalfCylinder(0.04, 0.35, 0.004)};
  const std::vector<MoverPiece> pieces = CoverByBoxes(lists, origin_W);
  ASSERT_EQ(pieces.size(), 1U);
  EXPECT_LE(BoxCount(pieces), static_cast<std::size_t>(kMaxMoverBoxes));
  for (const Eigen::Vector3f& p : lists[0]) {
    EXPECT_EQ(DistanceTo(pieces, origin_W + p.cast<double>()), 0);
  }
  EXPECT_EQ(CoveredShare(pieces, lists, origin_W), 1);
  // No box reaches farther from the points than a cell and the margin do.
  for (const MoverPiece& piece : pieces) {
    for (const Aabb& box : piece.boxes_W) {
      for (int k = 0; k < 8; ++k) {
        const Vector3 corner_W = box.corner(static_cast<Aabb::CornerType>(k));
        double nearest_m = 1e9;
        for (const Eigen::Vector3f& p : lists[0]) {
          nearest_m = std::min(nearest_m, (origin_W + p.cast<double>() - corner_W).norm());
        }
        EXPECT_LT(nearest_m, 0.07);
      }
    }
  }
}

TEST(MoverPieces, GrowTheirCellsRatherThanLosePoints) {
  Points far_apart;
  RandomDraws draws(3, 0);
  for (int i = 0; i < 3'000; ++i) {
    far_apart.push_back(
        Eigen::Vector3f(draws.Uniform(-1, 1), draws.Uniform(-1, 1), draws.Uniform(0, 0.5)));
  }
  const std::vector<Points> lists = {far_apart, HalfCylinder(0.03, 0.2, 0.005)};
  const std::vector<MoverPiece> pieces = CoverByBoxes(lists, Vector3::Zero());
  EXPECT_LE(BoxCount(pieces), static_cast<std::size_t>(kMaxMoverBoxes));
  EXPECT_GT(CoveredShare(pieces, lists, Vector3::Zero()), 0.999);
}

TEST(MoverPieces, LeaveOutSingleStrayPoints) {
  Points points = HalfCylinder(0.04, 0.2, 0.004);
  points.emplace_back(0, 0, 1.5F);  // a mixed pixel far behind
  const std::vector<MoverPiece> pieces = CoverByBoxes(std::vector<Points>{points}, {0, 0, 0});
  EXPECT_GT(DistanceTo(pieces, {0, 0, 1.5}), 1);
  EXPECT_TRUE(CoverByBoxes({}, Vector3::Zero()).empty());
}

TEST(MoverPieces, SameInputGivesTheSameBoxes) {
  const std::vector<Points> lists = {HalfCylinder(0.05, 0.3, 0.003)};
  const auto a = CoverByBoxes(lists, {1, 2, 3});
  const auto b = CoverByBoxes(lists, {1, 2, 3});
  ASSERT_EQ(a.size(), b.size());
  ASSERT_EQ(a[0].boxes_W.size(), b[0].boxes_W.size());
  for (std::size_t i = 0; i < a[0].boxes_W.size(); ++i) {
    EXPECT_TRUE(a[0].boxes_W[i].min() == b[0].boxes_W[i].min());
    EXPECT_TRUE(a[0].boxes_W[i].max() == b[0].boxes_W[i].max());
  }
}

}  // namespace
}  // namespace cwm::perception
