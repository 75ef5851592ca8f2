// Exact signed distances between pairs of solid shapes: closed forms if one exists, else GJK for
// the distance and an exact or iterative search for the minimum translation. Double precision,
// deterministic and thread safe. No allocation, except for pairs of meshes (hulls are built by the
// first query, and contacts of flush surfaces are collected).
#pragma once

#include <limits>
#include <memory>
#include <optional>

#include "collision/geometry/shape.h"
#include "collision/kernels/pair_distance.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// A shape with the data that is computed once and used by every pair: convex pieces of a plate, the
// triangle tree of a mesh. Immutable.
class ExactGeometry;
// Prepares a shape; nullptr if `work` ended it. Large meshes take seconds.
std::shared_ptr<const ExactGeometry> PrepareExact(const Shape& shape, WorkCounter* work = nullptr);

struct PlacedExact {
  const ExactGeometry& geometry;
  const Pose& X_FS;
};

// Signed distance of A and B in frame F. The search may stop once the distance is known to exceed
// `max_distance_m`: the distance returned is then a lower bound > max_distance_m, and the witness
// points are not meaningful.
//
// Separated pairs are kExact; kBounded if the search between round shapes of very different sizes
// leaves more than 1e-7 m open (the true distance is then at most distance_m). Overlapping pairs:
// * two convex shapes, or a half-space and anything: the minimum translation that separates them,
//   kExact; kBounded if the search with a cylinder or cone runs out of work with more than 1e-7 m
//   open;
// * a plate of several convex pieces: the depth of the deepest pair of pieces. The least
//   translation is at least that and at most the depth of the convex hulls: kBounded by the
//   difference, kExact if there is none;
// * a watertight mesh: the largest depth among the first 64 overlapping pairs of triangles (or of a
//   triangle and the convex shape), of a point that lies inside, or of a hull in the solid. The
//   minimum translation is at least that and at most the depth of the hull around the mesh:
//   kBounded by the difference, kExact if there is none. Containment counts as penetration,
//   whichever solid contains the other. Closed holes are not considered: see mesh_caps.h;
// * an open mesh: kSurfaceOnly, the same without an inside, and with the same bound if it overlaps;
// * two half-spaces: if their normals are opposite, the thickness of the layer that both fill,
//   kExact. Otherwise no translation separates them: -kMaxCoordinate_m and kDegraded, without
//   meaningful witness points.
//
// Searches over several pieces or triangles count their work with `work` and end if it says so; the
// answer is then void.
PairDistance ExactDistance(const PlacedExact& a, const PlacedExact& b,
                           double max_distance_m = std::numeric_limits<double>::infinity(),
                           WorkCounter* work = nullptr);

// The same, at most `slack` times as far as the least distance of a mesh, with the difference in
// bound_m: much faster between large meshes. Other pairs, and overlaps, are as above.
PairDistance ExactDistanceWithin(const PlacedExact& a, const PlacedExact& b, double max_distance_m,
                                 double slack, WorkCounter* work = nullptr);

// A lower bound of the distance, by convex solids around meshes and plates: some microseconds for
// any number of triangles, once the hulls of the meshes are built. Empty if these solids meet, if
// one of the shapes is a half-space, or if both are convex, so that the distance itself is as
// cheap.
std::optional<double> ExactLowerBound_m(const PlacedExact& a, const PlacedExact& b);

// True if the signed distance is negative, found without measuring it. Exact for two half-spaces
// too.
bool ExactOverlap(const PlacedExact& a, const PlacedExact& b, WorkCounter* work = nullptr);

// First hit of a ray with the surface of the solid, from outside or inside. The surface of a closed
// mesh is that of the union of its shells.
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
