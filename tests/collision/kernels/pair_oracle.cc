#include "tests/collision/kernels/pair_oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "collision/geometry/signed_distance.h"

namespace cwm::collision {
namespace {

struct Height {
  Vector3 n;  // in the shape's frame

  double radial() const { return std::hypot(n.x(), n.y()); }
  double operator()(const Sphere& s) const { return s.radius_m; }
  double operator()(const Box& s) const { return 0.5 * s.size_m.dot(n.cwiseAbs()); }
  double operator()(const Cylinder& s) const {
    return s.radius_m * radial() + 0.5 * s.length_m * std::abs(n.z());
  }
  double operator()(const Cone& s) const {
    return std::max(s.radius_bottom_m * radial() - 0.5 * s.length_m * n.z(),
                    s.radius_top_m * radial() + 0.5 * s.length_m * n.z());
  }
  double operator()(const Capsule& s) const {
    return s.radius_m + 0.5 * s.length_m * std::abs(n.z());
  }
  double operator()(const HalfSpace&) const {
    return n.z() >= 1 ? 0 : std::numeric_limits<double>::infinity();
  }
  double operator()(const Plate& s) const {
    double highest = -std::numeric_limits<double>::infinity();
    for (const Vector2& p : s.outline) highest = std::max(highest, n.head<2>().dot(p));
    return highest + std::max(0.0, -n.z() * s.thickness_m);
  }
  double operator()(const Convex& s) const { return OverVertices(*s.hull); }
  double operator()(const Mesh& s) const { return OverVertices(*s.mesh); }

  double OverVertices(const TriangleMesh& mesh) const {
    double highest = -std::numeric_limits<double>::infinity();
    for (const Vector3& v : mesh.vertices) highest = std::max(highest, n.dot(v));
    return highest;
  }
};

double RadiusOf(const Shape& shape) {
  double reach = 0;
  for (const Vector3& n : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1)}) {
    reach += HeightAlong(shape, Pose::Identity(), n) + HeightAlong(shape, Pose::Identity(), -n);
  }
  return reach;
}

// Pattern search on the sphere of directions, with bounded work.
double Descend(const PosedPair& pair, Vector3 n, double step) {
  double best = OverlapAlong(pair, n);
  for (int round = 0; round < 60 && step > 1e-10; ++round) {
    const Matrix3 basis = BasisFromZ(n);
    bool improved = false;
    for (int i = 0; i < 12; ++i) {
      const double angle = std::numbers::pi / 6 * i;
      const Vector3 candidate =
          (n + step * (std::cos(angle) * basis.col(0) + std::sin(angle) * basis.col(1)))
              .normalized();
      const double overlap = OverlapAlong(pair, candidate);
      if (overlap >= best) continue;
      best = overlap;
      n = candidate;
      improved = true;
    }
    step *= improved ? 1.0 : 0.35;
  }
  return best;
}

}  // namespace

double HeightAlong(const Shape& shape, const Pose& X_FS, const Vector3& n) {
  return n.dot(X_FS.translation()) + std::visit(Height{X_FS.linear().transpose() * n}, shape);
}

double OverlapAlong(const PosedPair& pair, const Vector3& n) {
  return HeightAlong(pair.a, pair.X_FA, n) + HeightAlong(pair.b, pair.X_FB, -n);
}

double SizeOf(const PosedPair& pair) {
  return RadiusOf(pair.a) + RadiusOf(pair.b) +
         (pair.X_FA.translation() - pair.X_FB.translation()).norm();
}

double MinOverlapNear(const PosedPair& pair, const Vector3& n, double enough_m) {
  // The ridges of long shapes are narrow, and a search with large steps misses them.
  double min_m = OverlapAlong(pair, n);
  for (double step = 1e-3; step >= 1e-8 && min_m > enough_m; step *= 0.1) {
    min_m = std::min(min_m, Descend(pair, n, step));
  }
  return min_m;
}

AnswerErrors ErrorsOf(const PosedPair& pair, const PairDistance& answer) {
  const double on_a = SignedDistance_m(pair.a, pair.X_FA.inverse() * answer.point_a);
  const double on_b = SignedDistance_m(pair.b, pair.X_FB.inverse() * answer.point_b);
  // The direction of a tiny gap consists of rounding; the best direction is near it.
  const double proven_m = -answer.distance_m + 1e-12 * SizeOf(pair);
  const double least = answer.distance_m > 0 ? MinOverlapNear(pair, answer.normal, proven_m)
                                             : OverlapAlong(pair, answer.normal);
  const Vector3 gap = answer.point_b - answer.point_a - answer.distance_m * answer.normal;
  return {std::abs(answer.distance_m + least),
          std::max({std::abs(on_a), std::abs(on_b), gap.norm()}),
          std::abs(answer.normal.norm() - 1)};
}

double SearchMinOverlap(const PosedPair& pair, int samples, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<std::pair<double, Vector3>> starts;
  const auto add = [&](const Vector3& v) {
    if (!(v.norm() > 1e-6)) return;
    const Vector3 n = v.normalized();
    starts.emplace_back(OverlapAlong(pair, n), n);
    starts.emplace_back(OverlapAlong(pair, -n), -n);
  };
  for (int i = 0; i < 3; ++i) {
    add(pair.X_FA.linear().col(i));
    add(pair.X_FB.linear().col(i));
    for (int j = 0; j < 3; ++j) add(pair.X_FA.linear().col(i).cross(pair.X_FB.linear().col(j)));
  }
  add(pair.X_FB.translation() - pair.X_FA.translation());
  for (int i = 0; i < samples; ++i) add({normal(random), normal(random), normal(random)});
  std::sort(starts.begin(), starts.end(),
            [](const auto& x, const auto& y) { return x.first < y.first; });
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < std::min<std::size_t>(starts.size(), 6); ++i) {
    best = std::min(best, Descend(pair, starts[i].second, 0.1));
  }
  return best;
}

}  // namespace cwm::collision
