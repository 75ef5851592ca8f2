// Pairs with a solid that is not convex: plates as convex pieces, meshes as triangles.
#pragma once

#include <limits>
#include <optional>

#include "collision/kernels/exact_geometry.h"
#include "collision/kernels/pair_distance.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// The range of a search and the counter that may end it: see ExactDistance.
struct SearchLimits {
  double max_distance_m = std::numeric_limits<double>::infinity();
  WorkCounter* work = nullptr;
  // Searches over triangles leave out pairs that are nearer than the best one by less than this
  // factor, which is at least 1: the distance found is at most so many times the least one.
  double slack = 1;
};

// The distance of a half-space A and any bounded B, in the frame of A. Exact, also as the least
// translation; kSurfaceOnly for an open mesh.
PairDistance HalfSpaceToAny(const ExactGeometry& b, const Pose& X_AB, const SearchLimits& limits);

// The distance of two solids made of convex pieces, in the frame of A. Exact if separated; else the
// depth of the deepest pair of pieces, which is at most the minimum translation. kBounded by the
// depth of the convex hulls, which is at least that translation.
PairDistance PiecesToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                            const SearchLimits& limits);

// The distance of a mesh A and a solid B made of convex pieces, in the frame of A.
PairDistance MeshToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                          const SearchLimits& limits);

// The distance of two meshes, in the frame of A.
PairDistance MeshToMesh(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        const SearchLimits& limits);

// The distance of convex solids around two bounded shapes; empty if these solids meet. The solid
// around a mesh is its hull, or its box if it has no hull.
std::optional<double> LowerBoundByEnclosures_m(const ExactGeometry& a, const ExactGeometry& b,
                                               const Pose& X_AB);

// True if the distance of the pair, as returned by the corresponding function above, is negative.
// The first parts that overlap end the search.
bool HalfSpaceOverlapsAny(const ExactGeometry& b, const Pose& X_AB, WorkCounter* work);
bool PiecesOverlap(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                   WorkCounter* work);
bool MeshOverlapsPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        WorkCounter* work);
bool MeshesOverlap(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                   WorkCounter* work);

// A point inside two closed meshes whose triangles touch, in the frame of A (see flush_overlap.h).
// Empty if there is none or a mesh is open.
std::optional<Vector3> PointInTouchingMeshes(const ExactGeometry& a, const ExactGeometry& b,
                                             const Pose& X_AB, WorkCounter* work);

// Sets accuracy and bound of a penetrating answer that was found for parts, so that its depth is at
// most the true one: kBounded by the depth of the convex enclosures, kExact if that leaves nothing
// open, kSurfaceOnly with the same bound for an open mesh.
PairDistance WithDepthBound(const PairDistance& deepest_part, const ExactGeometry& a,
                            const ExactGeometry& b, const Pose& X_AB);

}  // namespace cwm::collision
