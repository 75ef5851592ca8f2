#include "collision/geometry/mesh_closing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <set>
#include <utility>

#include "collision/geometry/shape.h"
#include "collision/geometry/tessellate.h"
#include "collision/geometry/winding.h"

namespace cwm {
namespace {

// A cube of 1 m, whose triangles share no vertices, as in an STL file.
TriangleMesh Cube() {
  const TriangleMesh shared = Tessellate(Box{{1, 1, 1}});
  TriangleMesh mesh;
  for (const TriangleMesh::Triangle& t : shared.triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const std::uint32_t corner : t) mesh.vertices.push_back(shared.vertices[corner]);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

// Splits the first edge of the first triangle at shares of it, on its own side alone.
TriangleMesh CubeWithSplitEdge(std::vector<double> shares) {
  TriangleMesh mesh = Cube();
  const TriangleMesh::Triangle t = mesh.triangles.front();
  const Vector3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]];
  std::uint32_t from = t[0];
  mesh.triangles.erase(mesh.triangles.begin());
  for (const double share : shares) {
    // Rounded, as a file in single precision has it.
    mesh.vertices.push_back((a + share * (b - a)).cast<float>().cast<double>());
    const auto to = static_cast<std::uint32_t>(mesh.vertices.size() - 1);
    mesh.triangles.push_back({from, to, t[2]});
    from = to;
  }
  mesh.triangles.push_back({from, t[1], t[2]});
  return mesh;
}

TEST(Close, LeavesOutATriangleThatIsThereTwice) {
  TriangleMesh mesh = Cube();
  const TriangleMesh::Triangle t = mesh.triangles[3];
  mesh.triangles.push_back({t[1], t[2], t[0]});
  ASSERT_FALSE(IsWatertight(mesh));
  const auto closed = Close(mesh);
  ASSERT_TRUE(closed);
  EXPECT_TRUE(IsWatertight(closed->mesh));
  EXPECT_EQ(closed->repeated, 1u);
  EXPECT_EQ(closed->split_edges, 0u);
  EXPECT_NEAR(SignedVolume_m3(closed->mesh), 1, 1e-12);
}

TEST(Close, SplitsAnEdgeAtVerticesThatLieOnIt) {
  for (const std::vector<double>& shares : {std::vector<double>{0.5}, {0.3}, {0.1, 0.35, 0.9}}) {
    const TriangleMesh mesh = CubeWithSplitEdge(shares);
    ASSERT_FALSE(IsWatertight(mesh));
    const auto closed = Close(mesh);
    ASSERT_TRUE(closed) << shares.size();
    EXPECT_TRUE(IsWatertight(closed->mesh));
    EXPECT_EQ(closed->split_edges, 1u);
    EXPECT_EQ(closed->mesh.triangles.size(), 12 + 2 * shares.size());
    EXPECT_NEAR(SignedVolume_m3(closed->mesh), 1, 1e-6);
  }
}

TEST(Close, MendsBothDefectsTogether) {
  TriangleMesh mesh = CubeWithSplitEdge({0.4});
  mesh.triangles.push_back(mesh.triangles[5]);
  const auto closed = Close(mesh);
  ASSERT_TRUE(closed);
  EXPECT_EQ(closed->repeated, 1u);
  EXPECT_EQ(closed->split_edges, 1u);
}

TEST(Close, LeavesWhatHasTwoMeanings) {
  TriangleMesh hole = Cube();
  hole.triangles.pop_back();
  EXPECT_FALSE(Close(hole)) << "half a side is missing";
  TriangleMesh reversed = Tessellate(Sphere{1}, 0.001);
  const TriangleMesh::Triangle t = reversed.triangles[0];
  reversed.triangles.push_back({t[0], t[2], t[1]});
  EXPECT_FALSE(Close(reversed)) << "a triangle that is there in both directions";
  TriangleMesh turned = Tessellate(Sphere{1}, 0.001);
  std::swap(turned.triangles[5][0], turned.triangles[5][1]);
  EXPECT_FALSE(Close(turned));
  EXPECT_FALSE(Close({}));
}

// The cube without a sliver of its first triangle, which is as wide as this at one corner.
TriangleMesh CubeWithMissingSliver(double width_m) {
  TriangleMesh mesh = CubeWithSplitEdge({width_m});
  // The first of the two triangles into which the first one was split.
  mesh.triangles.erase(mesh.triangles.end() - 2);
  return mesh;
}

TEST(Close, CapsAMissingSliver) {
  const TriangleMesh mesh = CubeWithMissingSliver(0.01);
  const auto closed = Close(mesh);
  ASSERT_TRUE(closed);
  EXPECT_TRUE(IsWatertight(closed->mesh));
  EXPECT_NEAR(SignedVolume_m3(closed->mesh), 1, 1e-6);
  ASSERT_EQ(closed->caps.size(), 1u);
  const MeshCap& cap = closed->caps.front();
  EXPECT_GE(cap.diameter_m, 1);
  EXPECT_LE(cap.diameter_m, std::sqrt(2) + 1e-9);
  // A triangle as high as the sliver is wide: the capsule is no thicker than that.
  EXPECT_LE(cap.bound_m(), 0.01 + 1e-9);
}

TEST(Close, CapsASlitBesideAnEdge) {
  TriangleMesh off = CubeWithSplitEdge({0.5});
  off.vertices.back() *= 1.001;
  const auto closed = Close(off);
  ASSERT_TRUE(closed);
  EXPECT_EQ(closed->split_edges, 0u);
  ASSERT_EQ(closed->caps.size(), 1u);
  EXPECT_NEAR(closed->caps.front().diameter_m, 1, 1e-9);
  EXPECT_LE(closed->caps.front().bound_m(), 0.002);
}

// A ball of 1 m without the triangles around some of its vertices.
TriangleMesh BallWithHoles(const std::vector<Vector3>& at) {
  TriangleMesh mesh = Tessellate(Sphere{1}, 0.001);
  for (const Vector3& direction : at) {
    std::uint32_t nearest = 0;
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      if (mesh.vertices[v].dot(direction) > mesh.vertices[nearest].dot(direction)) nearest = v;
    }
    std::erase_if(mesh.triangles, [&](const TriangleMesh::Triangle& t) {
      return std::ranges::find(t, nearest) != t.end();
    });
  }
  return mesh;
}

TEST(Close, CapsEachHoleByAFanAroundWhichTheInsideIsThatOfTheWholeMesh) {
  const TriangleMesh whole = Tessellate(Sphere{1}, 0.001);
  const TriangleMesh open = BallWithHoles({{1, 0.2, 0.3}, {-0.3, -1, 0.1}});
  ASSERT_FALSE(IsWatertight(open));
  const auto closed = Close(open);
  ASSERT_TRUE(closed);
  ASSERT_EQ(closed->caps.size(), 2u);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.2, 1.2);
  int near_a_hole = 0;
  for (int k = 0; k < 2000; ++k) {
    Vector3 p(uniform(random), uniform(random), uniform(random));
    // Every second point lies close to a hole, where the two surfaces differ.
    if (k % 2 == 0) p = closed->caps[k % 4 / 2].axis[0] + 0.1 * p;
    const bool is_near = std::ranges::any_of(closed->caps, [&](const MeshCap& cap) {
      const Vector3 along = cap.axis[1] - cap.axis[0];
      const double share = std::clamp((p - cap.axis[0]).dot(along) / along.squaredNorm(), 0.0, 1.0);
      return (p - cap.axis[0] - share * along).norm() <= cap.radius_m;
    });
    near_a_hole += is_near ? 1 : 0;
    if (!is_near) {
      EXPECT_EQ(WindingNumber(whole, p) > 0.5, WindingNumber(closed->mesh, p) > 0.5) << k;
    }
  }
  EXPECT_GT(near_a_hole, 50);
}

TEST(Close, DiffersFromTheGeneralisedWindingNumberByWhatTheCapsFill) {
  // Barill et al. 2018: at a distance d, a surface of area S fills at most S / d^2 of 4 pi.
  const TriangleMesh open = BallWithHoles({{0, 0, 1}});
  const auto closed = Close(open);
  ASSERT_TRUE(closed);
  double area_m2 = 0;
  for (std::size_t k = open.triangles.size(); k < closed->mesh.triangles.size(); ++k) {
    const auto& [a, b, c] = closed->mesh.triangles[k];
    const Vector3& corner = closed->mesh.vertices[a];
    area_m2 +=
        0.5 * (closed->mesh.vertices[b] - corner).cross(closed->mesh.vertices[c] - corner).norm();
  }
  const MeshCap& cap = closed->caps.front();
  const Vector3 middle = 0.5 * (cap.axis[0] + cap.axis[1]);
  for (const double height_m : {0.2, 0.6, 0.9, 1.3, 2.0}) {
    const Vector3 p(0, 0, height_m);
    const double distance_m = (p - middle).norm() - 0.5 * cap.diameter_m - cap.radius_m;
    if (distance_m <= 0) continue;
    const double off =
        std::abs(WindingNumber(open, p) - std::round(WindingNumber(closed->mesh, p)));
    EXPECT_LE(off, area_m2 / (4 * std::numbers::pi * distance_m * distance_m)) << height_m;
    EXPECT_GT(off, 0) << height_m;
  }
}

TEST(Close, LeavesOpenWhatIsMeantToBeOpen) {
  TriangleMesh bowl = Tessellate(Sphere{1}, 0.001);
  std::erase_if(bowl.triangles, [&](const TriangleMesh::Triangle& t) {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return bowl.vertices[v].z() > 0.2; });
  });
  const MeshClosing closing = TryClose(bowl);
  EXPECT_FALSE(closing.closed);
  EXPECT_EQ(closing.opening.holes, 1u);
  EXPECT_GT(closing.opening.largest_m, 1.5);
  EXPECT_GT(closing.opening.area_share, 0.2);

  TriangleMesh soup = Tessellate(Sphere{1}, 0.001);
  for (std::size_t k = 0; k < soup.triangles.size(); k += 2)
    std::swap(soup.triangles[k][0], soup.triangles[k][1]);
  const MeshClosing of_soup = TryClose(soup);
  EXPECT_FALSE(of_soup.closed);
  EXPECT_GT(of_soup.opening.edges, 100u);
  EXPECT_EQ(of_soup.opening.holes, 0u);
}

TEST(Close, CapsAtMost64Holes) {
  const auto ball_without = [](std::size_t count) {
    TriangleMesh mesh = Tessellate(Sphere{1}, 0.00005);
    std::set<std::uint32_t> used;
    std::erase_if(mesh.triangles, [&](const TriangleMesh::Triangle& t) {
      const bool is_apart =
          std::ranges::none_of(t, [&](std::uint32_t v) { return used.contains(v); });
      if (count == 0 || !is_apart) return false;
      used.insert(t.begin(), t.end());
      --count;
      return true;
    });
    return mesh;
  };
  const auto closed = Close(ball_without(64));
  ASSERT_TRUE(closed);
  EXPECT_EQ(closed->caps.size(), 64u);
  const MeshClosing closing = TryClose(ball_without(65));
  EXPECT_FALSE(closing.closed);
  EXPECT_EQ(closing.opening.holes, 65u);
}

TEST(SolidOf, SaysWhatAMeshIs) {
  const auto shared = [](TriangleMesh mesh) {
    return std::make_shared<const TriangleMesh>(std::move(mesh));
  };
  const auto cube = shared(Cube());
  const auto whole = SolidOf(cube);
  EXPECT_TRUE(whole->watertight);
  EXPECT_EQ(whole->mesh, cube);
  EXPECT_EQ(whole->caps, nullptr);
  EXPECT_EQ(SolidOf(shared(CubeWithSplitEdge({0.5})))->caps, nullptr);
  const auto capped = SolidOf(shared(CubeWithMissingSliver(0.01)));
  EXPECT_TRUE(capped->watertight);
  ASSERT_NE(capped->caps, nullptr);
  EXPECT_NE(*capped, *SolidOf(capped->mesh)) << "the same triangles, of which some are caps";
  TriangleMesh open = Cube();
  open.triangles.pop_back();
  EXPECT_FALSE(SolidOf(shared(open))->watertight);
}

}  // namespace
}  // namespace cwm
