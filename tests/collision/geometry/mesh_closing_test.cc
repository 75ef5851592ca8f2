#include "collision/geometry/mesh_closing.h"

#include <gtest/gtest.h>

#include <utility>

#include "collision/geometry/shape.h"
#include "collision/geometry/tessellate.h"

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

TEST(Close, InventsNothingWhereSomethingIsMissing) {
  TriangleMesh hole = Cube();
  hole.triangles.pop_back();
  EXPECT_FALSE(Close(hole));
  TriangleMesh reversed = Cube();
  const TriangleMesh::Triangle t = reversed.triangles[0];
  reversed.triangles.push_back({t[0], t[2], t[1]});
  EXPECT_FALSE(Close(reversed)) << "a side that is there in both directions has two meanings";
  TriangleMesh off = CubeWithSplitEdge({0.5});
  off.vertices.back() *= 1.001;  // beside the edge
  EXPECT_FALSE(Close(off));
  EXPECT_FALSE(Close({}));
}

}  // namespace
}  // namespace cwm
