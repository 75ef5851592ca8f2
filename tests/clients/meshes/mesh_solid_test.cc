#include "clients/meshes/mesh_solid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "collision/geometry/tessellate.h"

namespace cwm::meshes {
namespace {

TriangleMesh Ball() { return Tessellate(Sphere{0.1}, 1e-4); }

// The ball without the triangle of each of these indices.
TriangleMesh BallWithout(std::vector<std::size_t> missing) {
  TriangleMesh mesh = Ball();
  std::ranges::sort(missing, std::greater<>());
  for (const std::size_t k : missing) {
    mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return mesh;
}

double LongestEdge_m(const TriangleMesh& mesh, std::size_t k) {
  const auto& [a, b, c] = mesh.triangles[k];
  const Vector3 &p = mesh.vertices[a], &q = mesh.vertices[b], &r = mesh.vertices[c];
  return std::max({(p - q).norm(), (q - r).norm(), (r - p).norm()});
}

std::string Millimetres(double length_m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * length_m);
  return text;
}

TEST(DescribeSolid, NamesASolidAndWhatWasMended) {
  EXPECT_EQ(DescribeSolid(Ball()).text, "closed");
  TriangleMesh twice = Ball();
  twice.triangles.push_back(twice.triangles[3]);
  EXPECT_EQ(DescribeSolid(twice).text, "closed (a repeated triangle left out)");
  EXPECT_FALSE(DescribeSolid(twice).has_caps);
}

TEST(DescribeSolid, NamesTheHolesThatCapsClose) {
  const TriangleMesh ball = Ball();
  const MeshSolid one = DescribeSolid(BallWithout({100}));
  EXPECT_TRUE(one.has_caps);
  EXPECT_FALSE(one.is_open);
  EXPECT_EQ(one.text, "closed by a cap of a hole of " + Millimetres(LongestEdge_m(ball, 100)));
  const double largest_m = std::max(LongestEdge_m(ball, 100), LongestEdge_m(ball, 900));
  EXPECT_EQ(DescribeSolid(BallWithout({100, 900})).text,
            "closed by caps of 2 holes, the largest " + Millimetres(largest_m));
  TriangleMesh both = BallWithout({100});
  both.triangles.push_back(both.triangles[3]);
  EXPECT_EQ(DescribeSolid(both).text,
            "closed (a repeated triangle left out) by a cap of a hole of " +
                Millimetres(LongestEdge_m(ball, 100)));
}

TEST(DescribeSolid, SaysWhyAMeshIsOpen) {
  TriangleMesh box = Tessellate(Box{{1, 1, 1}});
  box.triangles.pop_back();
  const MeshSolid hole = DescribeSolid(box);
  EXPECT_TRUE(hole.is_open);
  EXPECT_EQ(hole.text, "open: a hole of 1414.2 mm, 9.1 % of its area");  // 0.5 of 5.5 m2
  TriangleMesh turned = Tessellate(Box{{1, 1, 1}});
  for (std::size_t k = 0; k < 3; ++k)
    std::swap(turned.triangles[4 * k][0], turned.triangles[4 * k][1]);
  const MeshSolid soup = DescribeSolid(turned);
  EXPECT_TRUE(soup.is_open);
  EXPECT_EQ(soup.text.substr(0, 6), "open: ");
  EXPECT_NE(soup.text.find(" edges with a triangle on one side only"), std::string::npos)
      << soup.text;
}

}  // namespace
}  // namespace cwm::meshes
