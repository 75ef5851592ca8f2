// Exact signed distances between pairs of solid shapes: closed forms where one exists, else GJK for
// the distance and an exact or iterative search for the least translation. Double precision,
// deterministic, no allocation for the closed forms; thread safe (pure functions).
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_answer.h"

namespace cwm::collision {

// A shape with what is computed once and used by every pair: convex pieces of a plate, the triangle
// tree of a mesh. Immutable.
class ExactGeometry;
std::shared_ptr<const ExactGeometry> PrepareExact(const Shape& shape);

struct PlacedExact {
  const ExactGeometry& geometry;
  const Pose& X_FS;
};

// True when the pair has an exact kernel.
bool ExactSupports(ShapeKind a, ShapeKind b);

// Signed distance of A and B in frame F. When the distance is known to exceed `max_distance_m` the
// search may stop: the distance returned is then some lower bound > max_distance_m and the
// witnesses are not meaningful.
PairDistance ExactDistance(const PlacedExact& a, const PlacedExact& b,
                           double max_distance_m = std::numeric_limits<double>::infinity());

// First hit of a ray with the surface, from outside or inside.
struct RayHit {
  double distance_m = 0;              // along the unit direction, >= 0
  Vector3 normal = Vector3::UnitZ();  // outward, unit, frame F
};
struct Ray {
  Vector3 origin;
  Vector3 direction;  // unit
  double max_distance_m = std::numeric_limits<double>::infinity();
};
std::optional<RayHit> ExactRay(const PlacedExact& shape, const Ray& ray);

}  // namespace cwm::collision
