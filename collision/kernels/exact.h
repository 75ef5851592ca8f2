// Exact signed distances between pairs of solid shapes: closed forms where one exists, else GJK for
// the distance and an exact or iterative search for the least translation. Double precision,
// deterministic, no allocation; thread safe (pure functions).
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_answer.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// A shape with what is computed once and used by every pair: convex pieces of a plate, the triangle
// tree of a mesh. Immutable.
class ExactGeometry;
// nullptr where `work` ended it: large meshes take seconds.
std::shared_ptr<const ExactGeometry> PrepareExact(const Shape& shape, WorkCounter* work = nullptr);

struct PlacedExact {
  const ExactGeometry& geometry;
  const Pose& X_FS;
};

// Signed distance of A and B in frame F. When the distance is known to exceed `max_distance_m` the
// search may stop: the distance returned is then some lower bound > max_distance_m and the
// witnesses are not meaningful.
//
// Separated pairs are kExact; kBounded where the search between round shapes of very different sizes
// leaves more than 1e-7 m open: they are then no farther apart than told. Overlapping ones:
// * two convex shapes, or a half-space and anything: the least translation that parts them, kExact;
//   kBounded where the search with a cylinder or cone runs out of work with more than 1e-7 m open;
// * a plate of several convex pieces: the depth of the deepest pair of pieces. The least
//   translation is at least that and at most the depth of the convex hulls: kBounded by the
//   difference, kExact where there is none;
// * a watertight mesh: penetrating, depth not known but for bounds. The answer is the largest depth
//   among the first 64 overlapping pairs of triangles (or of a triangle and the convex shape), or
//   of a point that lies inside; the least translation is at least that and at most the depth of
//   the mesh's box: kBounded by the difference. Containment counts as penetration, either way
//   round;
// * an open mesh: kSurfaceOnly, the same without an inside; where it overlaps, with the same bound;
// * two half-spaces: kExact where their normals are opposite, the layer that both fill. Others overlap
//   without end: -kLargestCoordinate_m, since no translation within a world parts them, kDegraded,
//   without meaningful witnesses.
//
// Searches of several pieces or triangles tell `work` what they do and end when it says so: the
// answer is void then.
PairDistance ExactDistance(const PlacedExact& a, const PlacedExact& b,
                           double max_distance_m = std::numeric_limits<double>::infinity(),
                           WorkCounter* work = nullptr);

// A distance that the pair is no nearer than, by convex solids around the two: for meshes and plates
// some microseconds however many triangles they have. Nothing where these solids meet, where no such
// solid is around one of them, or where the distance itself is told as soon.
std::optional<double> ExactLowerBound_m(const PlacedExact& a, const PlacedExact& b);

// Whether the signed distance is negative, told without measuring it. Exact for two half-spaces too.
bool ExactOverlap(const PlacedExact& a, const PlacedExact& b, WorkCounter* work = nullptr);

// First hit of a ray with the surface of the solid, from outside or inside. Of a closed mesh that is the
// surface of the union of its shells.
struct RayHit {
  double distance_m = 0;              // along the unit direction, >= 0
  Vector3 normal = Vector3::UnitZ();  // outward, unit, frame F
};
struct Ray {
  Vector3 origin;
  Vector3 direction;  // unit
  double max_distance_m = std::numeric_limits<double>::infinity();
};
std::optional<RayHit> ExactRay(const PlacedExact& shape, const Ray& ray,
                               WorkCounter* work = nullptr);

}  // namespace cwm::collision
