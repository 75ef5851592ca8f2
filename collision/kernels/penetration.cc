#include "collision/kernels/penetration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "collision/kernels/expanding_polytope.h"
#include "collision/kernels/gjk.h"

namespace cwm::collision {
namespace {

// chosen: share of the extent below which upper and lower bound count as equal: 1e-8 m for 10 m.
constexpr double kGapShare = 1e-9;

// Share of the extent. If D is flatter than this, it counts as a polygon or less, with depth 0.
constexpr double kFlatShare = 1e-13;

using Vertex = CoreDifference::Vertex;

class PolytopeSearch {
 public:
  explicit PolytopeSearch(const CoreDifference& difference)
      : difference_(difference), size_(difference.extent_m()), polytope_(kFlatShare * size_) {}

  Penetration Run() {
    best_.depth_m = std::numeric_limits<double>::infinity();
    if (!Start()) return WithWitnesses();
    double lower_bound = 0;
    while (!polytope_.IsFull()) {
      const int face = polytope_.NearestFace();
      if (face < 0) break;
      lower_bound = polytope_.OffsetOf(face);
      if (lower_bound >= best_.depth_m - kGapShare * size_) break;
      const Vertex vertex = difference_.Support(polytope_.NormalOf(face));
      const double height = vertex.w.dot(polytope_.NormalOf(face));
      if (height < best_.depth_m) Improve(face, height);
      if (height - lower_bound <= kGapShare * size_) {
        polytope_.Close(face);
      } else if (!polytope_.Expand(face, vertex)) {
        // Rounding prevents progress here, so the gap that this face leaves open stays in the
        // bound.
        abandoned_ = std::min(abandoned_, lower_bound);
        polytope_.Close(face);
      }
    }
    best_.bound_m = std::max(best_.depth_m - std::min(lower_bound, abandoned_), 0.0);
    return WithWitnesses();
  }

 private:
  Penetration WithWitnesses() const {
    Penetration answer = best_;
    answer.point_a = WitnessOnA(difference_, best_.depth_m, best_.normal);
    answer.point_b = answer.point_a - best_.depth_m * best_.normal;
    return answer;
  }

  void Improve(int face, double height) {
    best_.depth_m = height;
    best_.normal = polytope_.NormalOf(face);
  }

  // Builds the first tetrahedron from vertices of D that lie far apart. False, with the answer in
  // best_, if D is flat.
  bool Start() {
    std::array<Vertex, 6> far;
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3 axis = Vector3::Unit(static_cast<Eigen::Index>(i));
      far[2 * i] = difference_.Support(axis);
      far[2 * i + 1] = difference_.Support(-axis);
    }
    Vertex a = far[0], b = far[1];
    for (std::size_t i = 2; i < 6; i += 2) {
      if ((far[i].w - far[i + 1].w).norm() <= (a.w - b.w).norm()) continue;
      a = far[i];
      b = far[i + 1];
    }
    const Vector3 line = b.w - a.w;
    if (!(line.norm() > kFlatShare * size_)) return Flat(a, Vector3::UnitZ());
    const Vector3 u = BasisFromZ(line.normalized()).col(0), v = u.cross(line.normalized());
    const std::optional<Vertex> c = FarthestFrom(a, std::array<Vector3, 4>{u, v, u + v, u - v});
    if (!c) return Flat(a, u);
    const Vector3 n = line.cross(c->w - a.w).normalized();
    const std::optional<Vertex> d = FarthestFrom(a, std::array<Vector3, 1>{n});
    if (!d) return Flat(a, n);
    polytope_.Start({a, b, *c, *d});
    return true;
  }

  template <std::size_t n>
  std::optional<Vertex> FarthestFrom(const Vertex& from, const std::array<Vector3, n>& directions) {
    std::optional<Vertex> farthest;
    double max_height = kFlatShare * size_;
    for (const Vector3& direction : directions) {
      for (const double sign : {1.0, -1.0}) {
        const Vertex vertex = difference_.Support(sign * direction);
        const double height = sign * (vertex.w - from.w).dot(direction) / direction.norm();
        if (height <= max_height) continue;
        max_height = height;
        farthest = vertex;
      }
    }
    return farthest;
  }

  // Sets the answer for a D without extent along `normal`, so that a separation along it costs
  // nothing.
  bool Flat(const Vertex& vertex, const Vector3& normal) {
    best_.depth_m = vertex.w.dot(normal);
    best_.normal = normal;
    return false;
  }

  const CoreDifference& difference_;
  const double size_;
  ExpandingPolytope polytope_;
  Penetration best_;
  double abandoned_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Penetration FindPenetration(const CoreDifference& difference) {
  return PolytopeSearch(difference).Run();
}

}  // namespace cwm::collision
