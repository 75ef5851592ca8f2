// Closed meshes on a grid: their faces are flush, and their surfaces touch and often do not cross.
// The cells that they fill tell if they overlap.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact.h"
#include "collision/kernels/exact_geometry.h"

namespace cwm::collision {
namespace {

using Cell = std::array<int, 3>;

constexpr double kStep_m = 0.125;  // sums of steps are exact

// A plate on the grid as a mesh, and the cells that it fills.
struct Block {
  std::set<Cell> cells;
  std::shared_ptr<const ExactGeometry> geometry;
};

Block BlockOf(const std::vector<std::array<int, 2>>& outline, const std::set<Cell>& floor,
              int layers) {
  Block block;
  Plate plate{.outline = {}, .holes = {}, .thickness_m = layers * kStep_m};
  for (const auto& [x, y] : outline) plate.outline.emplace_back(x * kStep_m, y * kStep_m);
  for (const Cell& cell : floor) {
    for (int z = -layers; z < 0; ++z) block.cells.insert({cell[0], cell[1], z});
  }
  auto mesh = std::make_shared<const TriangleMesh>(Tessellate(plate));
  EXPECT_TRUE(IsWatertight(*mesh));
  block.geometry = PrepareExact(Mesh{.mesh = mesh, .watertight = true});
  return block;
}

std::vector<Block> Blocks() {
  const std::vector<std::array<int, 2>> u = {{0, 0}, {3, 0}, {3, 3}, {2, 3},
                                             {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  const std::set<Cell> in_u = {{0, 0}, {1, 0}, {2, 0}, {0, 1}, {0, 2}, {2, 1}, {2, 2}};
  const std::vector<std::array<int, 2>> l = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 3}, {0, 3}};
  const std::set<Cell> in_l = {{0, 0}, {1, 0}, {0, 1}, {0, 2}};
  const std::vector<std::array<int, 2>> bar = {{0, 0}, {2, 0}, {2, 1}, {0, 1}};
  return {BlockOf(u, in_u, 1), BlockOf(u, in_u, 3), BlockOf(l, in_l, 2),
          BlockOf(bar, {{0, 0}, {1, 0}}, 1), BlockOf(bar, {{0, 0}, {1, 0}}, 3)};
}

bool ShareRoom(const Block& a, const Block& b, const Cell& shift) {
  for (const Cell& cell : b.cells) {
    if (a.cells.contains({cell[0] + shift[0], cell[1] + shift[1], cell[2] + shift[2]})) return true;
  }
  return false;
}

void ExpectTold(const Block& a, const Block& b, const Pose& X_FA, const Pose& X_FB, bool overlap) {
  const PlacedExact at_a{*a.geometry, X_FA}, at_b{*b.geometry, X_FB};
  EXPECT_EQ(ExactOverlap(at_a, at_b), overlap);
  const PairDistance distance = ExactDistance(at_a, at_b);
  EXPECT_EQ(distance.distance_m < 0, overlap) << distance.distance_m;
  if (!overlap) return;
  EXPECT_NE(distance.accuracy, Accuracy::kSurfaceOnly);
  // The smallest overlap is a cell.
  EXPECT_GE(-distance.distance_m + distance.bound_m, kStep_m * (1 - 1e-9));
}

TEST(FlushMeshes, AreToldByTheCellsThatTheyFill) {
  const std::vector<Block> blocks = Blocks();
  int overlapping = 0, apart = 0;
  for (const Block& a : blocks) {
    for (const Block& b : blocks) {
      for (int k = 0; k < 7 * 7 * 7; ++k) {
        const Cell shift = {k % 7 - 3, k / 7 % 7 - 3, k / 49 - 3};
        const bool overlap = ShareRoom(a, b, shift);
        (overlap ? overlapping : apart) += 1;
        SCOPED_TRACE(::testing::Message()
                     << &a - blocks.data() << " and " << &b - blocks.data() << " moved by "
                     << shift[0] << " " << shift[1] << " " << shift[2]);
        const Vector3 by = kStep_m * Vector3(shift[0], shift[1], shift[2]);
        ExpectTold(a, b, Pose::Identity(), MakeTranslation(by.x(), by.y(), by.z()), overlap);
      }
    }
  }
  EXPECT_GT(overlapping, 900);
  EXPECT_GT(apart, 1000);
}

TEST(FlushMeshes, AreToldWhereverTheyLie) {
  const std::vector<Block> blocks = Blocks();
  const Pose X_WF = MakePose({20, -30, 5}, Quaternion(0.5, 0.1, -0.7, 0.3).normalized());
  for (const Block& a : blocks) {
    for (const Block& b : blocks) {
      for (int k = 0; k < 5 * 5 * 5; ++k) {
        const Cell shift = {k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2};
        if (!ShareRoom(a, b, shift)) continue;  // rounding may make touching blocks overlap
        const Vector3 by = kStep_m * Vector3(shift[0], shift[1], shift[2]);
        ExpectTold(a, b, X_WF, X_WF * MakeTranslation(by.x(), by.y(), by.z()), true);
      }
    }
  }
}

// The z coordinates of the hit and of its normal, for a ray down onto (x, 0.02, .).
std::pair<double, double> HeightAndNormal(const TriangleMesh& mesh, double x) {
  const auto solid =
      PrepareExact(Mesh{.mesh = std::make_shared<const TriangleMesh>(mesh), .watertight = true});
  const auto hit =
      ExactRay({*solid, Pose::Identity()}, {.origin = {x, 0.02, 5}, .direction = {0, 0, -1}});
  EXPECT_TRUE(hit.has_value());
  return hit ? std::pair(5 - hit->distance_m, hit->normal.z()) : std::pair(0.0, 0.0);
}

TriangleMesh CubeAt(double x, double size_m, bool is_inward) {
  TriangleMesh cube = Tessellate(Box{Vector3::Constant(size_m)});
  for (Vector3& v : cube.vertices) v.x() += x;
  for (TriangleMesh::Triangle& t : cube.triangles) {
    if (is_inward) std::swap(t[0], t[1]);
  }
  return cube;
}

TriangleMesh CombinedRule(TriangleMesh all, const std::vector<TriangleMesh>& others) {
  for (const TriangleMesh& other : others) {
    const auto first = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const TriangleMesh::Triangle& t : other.triangles) {
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return all;
}

TEST(ClosedMeshes, WoundInwardTellOfTheirSurfaceAsThoseWoundOutward) {
  const auto up =
      ::testing::Pair(::testing::DoubleNear(0.5, 1e-12), ::testing::DoubleNear(1, 1e-12));
  EXPECT_THAT(HeightAndNormal(CubeAt(0, 1, true), 0.1), up);
  // Next to each other, whichever is larger.
  for (const double other_m : {0.5, 3.0}) {
    for (const bool is_inward : {false, true}) {
      const TriangleMesh both =
          CombinedRule(CubeAt(0, 1, is_inward), {CubeAt(9, other_m, !is_inward)});
      EXPECT_THAT(HeightAndNormal(both, 0.1), up);
      EXPECT_NEAR(HeightAndNormal(both, 9.1).second, 1, 1e-12);
    }
  }
}

TEST(ClosedMeshes, KeepTheirCavitiesWhicheverWayTheyAreWound) {
  for (const bool is_inward : {false, true}) {
    const TriangleMesh hollow = CombinedRule(CubeAt(0, 1, is_inward), {CubeAt(0, 0.5, !is_inward)});
    for (const TriangleMesh& mesh : {hollow, CombinedRule(hollow, {CubeAt(9, 3, !is_inward)}),
                                     CombinedRule(CubeAt(9, 3, is_inward), {hollow})}) {
      const auto solid = PrepareExact(
          Mesh{.mesh = std::make_shared<const TriangleMesh>(mesh), .watertight = true});
      const auto from_within =
          ExactRay({*solid, Pose::Identity()}, {.origin = {0.1, 0.02, 0}, .direction = {0, 0, -1}});
      ASSERT_TRUE(from_within.has_value());
      EXPECT_NEAR(from_within->distance_m, 0.25, 1e-12);
      EXPECT_NEAR(from_within->normal.z(), 1, 1e-12);
      EXPECT_NEAR(HeightAndNormal(mesh, 0.1).second, 1, 1e-12);
    }
  }
}

}  // namespace
}  // namespace cwm::collision
