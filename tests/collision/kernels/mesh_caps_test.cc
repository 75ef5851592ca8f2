// Answers about meshes with closed holes must hold for every surface that could fill the holes.
#include "collision/kernels/mesh_caps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "collision/geometry/mesh_closing.h"
#include "collision/geometry/mesh_holes.h"
#include "collision/geometry/tessellate.h"
#include "collision/kernels/exact_geometry.h"
#include "collision/kernels/point_sample.h"
#include "tests/collision/kernels/random_pairs.h"

namespace cwm::collision {
namespace {

constexpr double kSize_m = 0.2;
const Pose kIdentity = Pose::Identity();
// derived: rounding of the kernels (README.md of kernels), for pairs of this size.
constexpr double kRounding_m = 1e-8;

// A mesh with holes, and one of the solids that it may be a part of.
struct Broken {
  TriangleMesh open, whole;
};

// A ball with dents, of which the triangles around some vertices are missing. The whole solid has a
// vertex at a random place in the convex hull of each hole's boundary instead.
Broken DentedBallWithHoles(int count, RandomPairs& random) {
  TriangleMesh ball = Tessellate(Sphere{0.5 * kSize_m}, 1e-4);
  for (Vector3& vertex : ball.vertices) vertex *= 1 - random.Uniform(0, 0.03);
  Broken broken{.open = ball, .whole = ball};
  std::set<std::uint32_t> used;
  while (count > 0) {
    const auto missing =
        static_cast<std::uint32_t>(random.Index(static_cast<int>(ball.vertices.size())));
    std::set<std::uint32_t> around;
    for (const TriangleMesh::Triangle& t : ball.triangles) {
      if (std::ranges::find(t, missing) != t.end()) around.insert(t.begin(), t.end());
    }
    if (std::ranges::any_of(around, [&](std::uint32_t v) { return used.contains(v); })) continue;
    used.insert(around.begin(), around.end());
    std::erase_if(broken.open.triangles, [&](const TriangleMesh::Triangle& t) {
      return std::ranges::find(t, missing) != t.end();
    });
    around.erase(missing);
    Vector3 sum = Vector3::Zero();
    double weights = 0;
    for (const std::uint32_t v : around) {
      const double weight = std::pow(random.Uniform(0, 1), 3);
      sum += weight * ball.vertices[v];
      weights += weight;
    }
    broken.whole.vertices[missing] = sum / weights;
    --count;
  }
  return broken;
}

Mesh CappedOf(const TriangleMesh& open) {
  const auto solid = SolidOf(std::make_shared<const TriangleMesh>(open));
  EXPECT_TRUE(solid->watertight);
  EXPECT_NE(solid->caps, nullptr);
  return *solid;
}

// The interval in which an answer says that the true distance lies.
struct Interval {
  double least_m, most_m;
};
Interval IntervalOf(const PairDistance& answer) {
  return {answer.distance_m - answer.bound_m - kRounding_m,
          answer.distance_m + (answer.distance_m < 0 ? 0 : answer.bound_m) + kRounding_m};
}
Interval IntervalOfCapped(const PairDistance& answer) {
  return {answer.distance_m - answer.bound_m - kRounding_m,
          answer.distance_m + answer.bound_m + kRounding_m};
}

struct Counts {
  int exact_apart = 0, exact_overlaps = 0, near = 0;
};

// Compares the answers about the capped mesh with those about the whole one.
void Compare(const ExactGeometry& capped, const ExactGeometry& whole, const Pose& X_FM,
             const PlacedExact& other, Counts& counts) {
  const PlacedExact mesh{capped, X_FM}, truth{whole, X_FM};
  const PairDistance of_truth = ExactDistance(truth, other);
  const PairDistance plain = ExactDistance(mesh, other);
  const double reach_m = std::abs(plain.distance_m) + plain.bound_m;
  const PairDistance answer = WithCapError(plain, CapErrorOf(mesh, other, reach_m));
  const Interval told = IntervalOfCapped(answer), true_m = IntervalOf(of_truth);
  EXPECT_LE(told.least_m, true_m.most_m);
  EXPECT_GE(told.most_m, true_m.least_m);
  const bool is_the_same = answer.bound_m == plain.bound_m;
  if (is_the_same) {
    EXPECT_EQ(answer.distance_m < 0, of_truth.distance_m < 0);
    (answer.distance_m < 0 ? counts.exact_overlaps : counts.exact_apart) += 1;
  } else {
    EXPECT_EQ(answer.accuracy, Accuracy::kBounded);
    ++counts.near;
  }
  if (!CapErrorOf(mesh, other, 0).any()) {
    EXPECT_EQ(ExactOverlap(mesh, other), ExactOverlap(truth, other));
  }
}

TEST(MeshCaps, BoundAnswersForEverySurfaceInTheHoles) {
  RandomPairs random(41);
  Counts counts;
  for (int round = 0; round < 12; ++round) {
    const Broken broken = DentedBallWithHoles(1 + round % 3, random);
    const Mesh mesh = CappedOf(broken.open);
    const auto capped = PrepareExact(mesh), whole = PrepareExact(MakeMesh(broken.whole));
    for (int k = 0; k < 60; ++k) {
      const ShapeKind kinds[] = {ShapeKind::kSphere, ShapeKind::kBox, ShapeKind::kCapsule,
                                 ShapeKind::kCylinder};
      Shape shape = random.HandSizedPair(kinds[k % 4], ShapeKind::kSphere).a;
      if (k % 5 == 0) shape = Sphere{0.003};  // fits into a hole
      const auto other = PrepareExact(shape);
      // Every second body is near a hole.
      Vector3 p = random.VectorOfLength(random.Uniform(0, 2 * kSize_m));
      const MeshCap& cap = (*mesh.caps)[static_cast<std::size_t>(k) % mesh.caps->size()];
      if (k % 2 == 0) p = cap.axis[0] * random.Uniform(0.9, 2.0);
      Pose X_FB = Pose::Identity();
      X_FB.linear() = random.Rotation();
      X_FB.translation() = p;
      Compare(*capped, *whole, Pose::Identity(), {*other, X_FB}, counts);
    }
  }
  EXPECT_GT(counts.exact_apart, 100);
  EXPECT_GT(counts.exact_overlaps, 30);
  EXPECT_GT(counts.near, 100);
}

TEST(MeshCaps, OfTwoMeshesAddTheirBounds) {
  RandomPairs random(42);
  Counts counts;
  for (int round = 0; round < 8; ++round) {
    const Broken broken = DentedBallWithHoles(2, random), other = DentedBallWithHoles(2, random);
    const Mesh mesh = CappedOf(broken.open);
    const auto capped = PrepareExact(mesh), whole = PrepareExact(MakeMesh(broken.whole));
    const Mesh other_mesh = CappedOf(other.open);
    const auto other_capped = PrepareExact(other_mesh);
    const auto other_whole = PrepareExact(MakeMesh(other.whole));
    for (int k = 0; k < 15; ++k) {
      Pose X_FB = Pose::Identity();
      X_FB.linear() = random.Rotation();
      X_FB.translation() = random.VectorOfLength(random.Uniform(0.1, 0.3));
      if (k % 2 == 0) {  // hole against hole
        const Vector3 here = (*mesh.caps)[0].axis[0], there = (*other_mesh.caps)[0].axis[0];
        X_FB.linear() = Quaternion::FromTwoVectors(there, -here).toRotationMatrix();
        X_FB.translation() = here * random.Uniform(1.95, 2.1);
      }
      const PlacedExact a{*capped, kIdentity}, b{*other_capped, X_FB};
      const PairDistance truth = ExactDistance({*whole, kIdentity}, {*other_whole, X_FB});
      const PairDistance plain = ExactDistance(a, b);
      const double reach_m = std::abs(plain.distance_m) + plain.bound_m;
      const PairDistance answer = WithCapError(plain, CapErrorOf(a, b, reach_m));
      EXPECT_LE(IntervalOfCapped(answer).least_m, IntervalOf(truth).most_m);
      EXPECT_GE(IntervalOfCapped(answer).most_m, IntervalOf(truth).least_m);
      (answer.bound_m == plain.bound_m ? counts.exact_apart : counts.near) += 1;
    }
  }
  EXPECT_GT(counts.exact_apart, 10);
  EXPECT_GT(counts.near, 20);
}

TEST(MeshCaps, BoundDistancesOfPointsAndMarkRays) {
  RandomPairs random(43);
  int exact = 0, near = 0, hits = 0, passing = 0;
  for (int round = 0; round < 6; ++round) {
    const Broken broken = DentedBallWithHoles(2, random);
    const Mesh mesh = CappedOf(broken.open);
    const auto capped = PrepareExact(mesh), whole = PrepareExact(MakeMesh(broken.whole));
    for (int k = 0; k < 200; ++k) {
      Vector3 p = random.VectorOfLength(random.Uniform(0, 0.7 * kSize_m));
      if (k % 2 == 0) p = (*mesh.caps)[0].axis[0] + random.VectorOfLength(random.Uniform(0, 0.02));
      const double inf = std::numeric_limits<double>::infinity();
      const double truth_m = MeshDistance_m(*whole->tree(), true, p, inf);
      const double told_m = MeshDistance_m(*capped->tree(), true, p, inf);
      const CapError error = CapErrorAt(*capped, p, std::abs(told_m));
      const PairDistance told = WithCapError({.distance_m = told_m}, error);
      EXPECT_LE(std::abs(told_m - truth_m), told.bound_m + kRounding_m);
      (error.any() ? near : exact) += 1;

      const Ray ray{p, random.Direction()};
      const auto hit = ExactRay({*capped, kIdentity}, ray),
                 true_hit = ExactRay({*whole, kIdentity}, ray);
      if (MayMeetCap({*capped, kIdentity}, ray)) {
        ++passing;
        continue;
      }
      ASSERT_EQ(hit.has_value(), true_hit.has_value());
      if (!hit) continue;
      EXPECT_NEAR(hit->distance_m, true_hit->distance_m, kRounding_m);
      ++hits;
    }
  }
  EXPECT_GT(exact, 300);
  EXPECT_GT(near, 200);
  EXPECT_GT(hits, 200);
  EXPECT_GT(passing, 50);
}

// A cube of 1 m without a triangle of 1 m x 10 mm at one of its edges.
Mesh CubeWithMissingSliver() {
  TriangleMesh mesh = Tessellate(Box{{1, 1, 1}});
  TriangleMesh::Triangle& t = mesh.triangles.front();
  const auto is_at_diagonal = [&] {
    return (mesh.vertices[t[2]] - mesh.vertices[t[0]]).norm() > 1.1;
  };
  while (is_at_diagonal()) std::rotate(t.begin(), t.begin() + 1, t.end());
  const Vector3 a = mesh.vertices[t[0]], b = mesh.vertices[t[1]];
  const auto beside = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(a + 0.01 * (b - a).normalized());
  t[0] = beside;
  return CappedOf(mesh);
}

TEST(MeshCaps, KeepACubeWithAMissingSliverSolidAndExactAwayFromIt) {
  const auto cube = PrepareExact(CubeWithMissingSliver());
  ASSERT_EQ(cube->caps().size(), 1u);
  EXPECT_LE(cube->caps().front().bound_m, 0.011);
  const auto ball = PrepareExact(Sphere{0.1});
  const PlacedExact mesh{*cube, kIdentity};
  EXPECT_TRUE(ExactOverlap(mesh, {*ball, kIdentity}));
  EXPECT_FALSE(CapErrorOf(mesh, {*ball, kIdentity}, 0).any());
  // Beside each face: the sliver is at one edge alone.
  int exact = 0;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      Vector3 p = Vector3::Zero();
      p[axis] = 0.65 * side;
      const Pose X_FB = MakePose(p, Quaternion::Identity());
      const PairDistance answer = ExactDistance(mesh, {*ball, X_FB});
      EXPECT_NEAR(answer.distance_m, 0.05, 1e-12);
      exact += CapErrorOf(mesh, {*ball, X_FB}, answer.distance_m).any() ? 0 : 1;
    }
  }
  EXPECT_EQ(exact, 6);
}

TEST(MeshCaps, LeaveHalfSpacesExact) {
  const auto cube = PrepareExact(CubeWithMissingSliver());
  const auto floor = PrepareExact(HalfSpace{});
  const Pose X_FM = MakeTranslation(0, 0, 0.501);
  EXPECT_FALSE(CapErrorOf({*cube, X_FM}, {*floor, kIdentity}, 10).any());
  EXPECT_FALSE(CapErrorOf({*floor, kIdentity}, {*cube, X_FM}, 10).any());
}

TEST(MeshCaps, WidenTheBoundsOfAnswers) {
  const PairDistance overlap{.distance_m = -0.003, .accuracy = Accuracy::kExact, .bound_m = 0};
  const PairDistance bounded = WithCapError(overlap, {.apart_m = 0.01});
  EXPECT_EQ(bounded.accuracy, Accuracy::kBounded);
  EXPECT_DOUBLE_EQ(bounded.bound_m, 0.013) << "the overlap may be a gap of 10 mm";
  const PairDistance apart{.distance_m = 0.003};
  EXPECT_DOUBLE_EQ(WithCapError(apart, {.apart_m = 0.01}).bound_m, 0.01);
  EXPECT_DOUBLE_EQ(WithCapError(apart, {.apart_m = 0.01, .depth_m = 0.05}).bound_m, 0.053);
  EXPECT_EQ(WithCapError(overlap, {}).accuracy, Accuracy::kExact);
}

}  // namespace
}  // namespace cwm::collision
