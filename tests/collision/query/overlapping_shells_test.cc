// Points in, and rays through, a mesh of several closed shells that overlap or contain each other.
// The solid is their union, and faces inside it are not part of the surface.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>
#include <vector>

#include "collision/geometry/tessellate.h"
#include "tests/collision/query/room_of_all_kinds.h"

namespace cwm::collision {
namespace {

TriangleMesh Turned(TriangleMesh mesh) {
  for (TriangleMesh::Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

TriangleMesh Joined(const std::vector<TriangleMesh>& shells) {
  TriangleMesh all;
  for (const TriangleMesh& shell : shells) {
    const auto offset = static_cast<std::uint32_t>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), shell.vertices.begin(), shell.vertices.end());
    for (const auto& [a, b, c] : shell.triangles) {
      all.triangles.push_back({a + offset, b + offset, c + offset});
    }
  }
  return all;
}

TriangleMesh Cube(double edge_m, const Vector3& centre) {
  TriangleMesh cube = Tessellate(Box{Vector3::Constant(edge_m)});
  for (Vector3& v : cube.vertices) v += centre;
  return cube;
}

std::shared_ptr<const WorldSnapshot> WorldOfMesh(TriangleMesh mesh) {
  return WorldOf({PutOf("mesh", {{.X_FS = Pose::Identity(), .shape = MakeMesh(std::move(mesh))}},
                        Pose::Identity())});
}

struct CubePlace {
  double edge_m;
  Vector3 centre;
  bool Holds(const Vector3& p, double room_m = 0) const {
    return (p - centre).cwiseAbs().maxCoeff() < 0.5 * edge_m + room_m;
  }
};

constexpr double kGrid_m = 0.01;

// Points on the surface of the union of cubes, so dense that every surface point has one within
// kGrid_m.
std::vector<Vector3> SurfaceOfUnion(const std::vector<CubePlace>& cubes) {
  std::vector<Vector3> places;
  for (const CubePlace& cube : cubes) {
    const int steps = static_cast<int>(cube.edge_m / kGrid_m);
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i <= steps; ++i) {
        for (int j = 0; j <= steps; ++j) {
          for (const double side : {-0.5, 0.5}) {
            Vector3 p;
            p[axis] = side * cube.edge_m;
            p[(axis + 1) % 3] = (static_cast<double>(i) / steps - 0.5) * cube.edge_m;
            p[(axis + 2) % 3] = (static_cast<double>(j) / steps - 0.5) * cube.edge_m;
            p += cube.centre;
            const bool buried = std::any_of(cubes.begin(), cubes.end(),
                                            [&](const CubePlace& c) { return c.Holds(p, -1e-9); });
            if (!buried) places.push_back(p);
          }
        }
      }
    }
  }
  return places;
}

struct Tally {
  int exact_inside = 0, bounded = 0, degraded = 0;
};

// Checks the label of each point: EXACT is the distance of the union, BOUNDED is no deeper than its
// bound.
Tally ExpectTrueLabels(const WorldSnapshot& world, const std::vector<CubePlace>& cubes) {
  const std::vector<Vector3> surface = SurfaceOfUnion(cubes);
  std::mt19937 random(7);
  const std::vector<Vector3> points = RandomPoints(3000, random, 0.9);
  const PointColumns columns = *SamplePoints(world, points, {});
  std::vector<double> bound_m(points.size(), 0);
  for (const PointColumns::Bound& bound : columns.bounds) bound_m[bound.row] = bound.bound_m;
  Tally result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool inside = std::any_of(cubes.begin(), cubes.end(),
                                    [&](const CubePlace& c) { return c.Holds(points[i]); });
    double off_m = std::numeric_limits<double>::infinity();
    for (const Vector3& place : surface) off_m = std::min(off_m, (place - points[i]).norm());
    const double min_m = std::abs(columns.distance_m[i]);
    EXPECT_EQ(columns.distance_m[i] < 0, inside) << points[i].transpose();
    EXPECT_GE(off_m, min_m - 1e-9) << points[i].transpose();
    if (columns.accuracy[i] == Accuracy::kDegraded) {
      ++result.degraded;
      continue;
    }
    EXPECT_LE(off_m, min_m + bound_m[i] + kGrid_m) << points[i].transpose();
    if (columns.accuracy[i] == Accuracy::kBounded) {
      EXPECT_TRUE(inside);
      ++result.bounded;
    } else {
      EXPECT_EQ(columns.accuracy[i], Accuracy::kExact);
      result.exact_inside += inside ? 1 : 0;
    }
  }
  return result;
}

TEST(OverlappingShells, DepthsInCubesThatInterpenetrateAreLabelledForWhatTheyAre) {
  const std::vector<CubePlace> cubes = {{0.8, {-0.2, -0.1, 0}}, {0.8, {0.2, 0.15, 0.1}}};
  const TriangleMesh mesh = Joined({Cube(0.8, {-0.2, -0.1, 0}), Cube(0.8, {0.2, 0.15, 0.1})});
  for (const TriangleMesh& either : {mesh, Turned(mesh)}) {
    const Tally result = ExpectTrueLabels(*WorldOfMesh(either), cubes);
    EXPECT_GT(result.exact_inside, 100);
    EXPECT_GT(result.bounded, 100);
    EXPECT_EQ(result.degraded, 0);
  }
}

TEST(OverlappingShells, DepthsAboutACubeWithinACubeAreLabelledForWhatTheyAre) {
  const auto world = WorldOfMesh(Joined({Cube(1, {0, 0, 0}), Cube(0.4, {0, 0, 0})}));
  const Tally result = ExpectTrueLabels(*world, {{1, {0, 0, 0}}, {0.4, {0, 0, 0}}});
  EXPECT_GT(result.exact_inside, 100);
  EXPECT_GT(result.bounded, 100);
  // In the inner cube, on its surface, and just outside it; the true depth is at least 0.28 m
  // everywhere.
  for (const double z_m : {0.1, 0.2 - 1e-7, 0.2, 0.2 + 1e-7, 0.22}) {
    const PointColumns columns = SampleOne(*world, {0.01, 0.02, z_m});
    EXPECT_EQ(columns.accuracy[0], Accuracy::kBounded) << z_m;
    ASSERT_EQ(columns.bounds.size(), 1u) << z_m;
    EXPECT_GE(columns.bounds[0].bound_m - columns.distance_m[0], 0.5 - z_m - 1e-9) << z_m;
  }
  const PointColumns outer = SampleOne(*world, {0.01, 0.02, 0.45});
  EXPECT_EQ(outer.accuracy[0], Accuracy::kExact);
  EXPECT_NEAR(outer.distance_m[0], -0.05, 1e-12);
}

TEST(OverlappingShells, ACavityIsExactAllOver) {
  const auto world = WorldOfMesh(Joined({Cube(1, {0, 0, 0}), Turned(Cube(0.4, {0, 0, 0}))}));
  std::mt19937 random(11);
  std::vector<Vector3> points = RandomPoints(2000, random, 0.6);
  // Points near the edges and corners of the cavity, which are the nearest surface from inside the
  // wall.
  for (const Vector3& off : RandomPoints(200, random, 1e-3)) {
    points.emplace_back(Vector3(0.2, 0.2, 0.1) + off);
    points.emplace_back(Vector3(0.2, 0.2, 0.2) + off);
  }
  points.emplace_back(0.2, 0.05, 0.03);
  points.emplace_back(0.2, 0.2, 0.03);
  points.emplace_back(0.2, 0.2, 0.2);
  const PointColumns columns = *SamplePoints(*world, points, {});
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double outer_m = points[i].cwiseAbs().maxCoeff() - 0.5;
    EXPECT_EQ(columns.accuracy[i], Accuracy::kExact) << points[i].transpose();
    if (outer_m > 0) continue;
    const Vector3 excess = points[i].cwiseAbs() - Vector3::Constant(0.2);
    const double wall_m = excess.maxCoeff() > 0 ? -excess.cwiseMax(0.0).norm() : -excess.maxCoeff();
    EXPECT_NEAR(columns.distance_m[i], std::max(wall_m, outer_m), 1e-12) << points[i].transpose();
  }
}

// The place at which the ray leaves or enters the union.
RayColumns Cast(const WorldSnapshot& world, const Vector3& origin, const Vector3& direction) {
  return *CastRays(world, std::vector<RayRow>{{origin, direction.normalized()}}, {});
}

TEST(OverlappingShells, RaysFromInsideEndWhereTheyLeaveTheUnion) {
  const auto nested = WorldOfMesh(Joined({Cube(1, {0, 0, 0}), Cube(0.4, {0, 0, 0})}));
  // From the inner cube, from its surface, and from between the two cubes, past and through the
  // inner one.
  for (const double from_m : {0.0, 0.1, 0.2, 0.3, -0.2, -0.3, -0.45}) {
    // Also along the diagonal of a face, where two triangles meet.
    for (const double aside_m : {0.0, 0.01}) {
      const RayColumns ray = Cast(*nested, {from_m, aside_m, aside_m}, Vector3::UnitX());
      ASSERT_TRUE(ray.hit[0]) << from_m;
      EXPECT_NEAR(ray.distance_m[0], 0.5 - from_m, 1e-12) << from_m;
      EXPECT_NEAR(ray.normal[0], 1, 1e-12) << from_m;
    }
  }
  const RayColumns outside = Cast(*nested, {-2, 0.01, 0.02}, Vector3::UnitX());
  EXPECT_NEAR(outside.distance_m[0], 1.5, 1e-12);
  EXPECT_NEAR(outside.normal[0], -1, 1e-12);
}

TEST(OverlappingShells, RaysMeetTheUnionOfCubesThatInterpenetrate) {
  const std::vector<CubePlace> cubes = {{0.8, {-0.2, -0.1, 0}}, {0.8, {0.2, 0.15, 0.1}}};
  const TriangleMesh mesh = Joined({Cube(0.8, cubes[0].centre), Cube(0.8, cubes[1].centre)});
  const auto world = WorldOfMesh(mesh);
  const auto holds = [&](const Vector3& p) { return cubes[0].Holds(p) || cubes[1].Holds(p); };
  std::mt19937 random(3);
  const std::vector<Vector3> origins = RandomPoints(1000, random, 0.9);
  const std::vector<Vector3> ways = RandomPoints(1000, random, 1);
  constexpr double kStep_m = 1e-3;
  int from_inside = 0;
  for (std::size_t i = 0; i < origins.size(); ++i) {
    const Vector3 way = ways[i].normalized();
    const RayColumns ray = Cast(*world, origins[i], way);
    const double until_m = ray.hit[0] ? ray.distance_m[0] : 4;
    const bool inside = holds(origins[i]);
    from_inside += inside ? 1 : 0;
    for (double t = kStep_m; t < until_m - 1e-9; t += kStep_m) {
      ASSERT_EQ(holds(origins[i] + t * way), inside) << i << " after " << t << " of " << until_m;
    }
    EXPECT_EQ(ray.hit[0] != 0, inside || until_m < 4);
    if (!ray.hit[0]) continue;
    EXPECT_NE(holds(origins[i] + (until_m + 1e-7) * way), inside) << i;
  }
  EXPECT_GT(from_inside, 100);
}

TEST(OverlappingShells, RaysInACavityMeetItsWall) {
  const auto world = WorldOfMesh(Joined({Cube(1, {0, 0, 0}), Turned(Cube(0.4, {0, 0, 0}))}));
  const RayColumns wall = Cast(*world, {0.01, 0.02, 0}, Vector3::UnitX());
  EXPECT_NEAR(wall.distance_m[0], 0.19, 1e-12);
  EXPECT_NEAR(wall.normal[0], -1, 1e-12);
  const RayColumns through = Cast(*world, {-0.4, 0.02, 0}, Vector3::UnitX());
  EXPECT_NEAR(through.distance_m[0], 0.2, 1e-12);
  // On the wall's own surface the distance is 0.
  EXPECT_NEAR(Cast(*world, {0.2, 0.02, 0.01}, Vector3::UnitX()).distance_m[0], 0, 1e-12);
}

}  // namespace
}  // namespace cwm::collision
