// Pairs with a solid that is not convex: plates as convex pieces, meshes as triangles.
#pragma once

#include <limits>
#include <optional>

#include "collision/kernels/exact_geometry.h"
#include "collision/kernels/pair_answer.h"
#include "collision/kernels/work_counter.h"

namespace cwm::collision {

// How far a search looks, and who may end it: see ExactDistance.
struct SearchLimits {
  double max_distance_m = std::numeric_limits<double>::infinity();
  WorkCounter* work = nullptr;
};

// A half-space as A and anything bounded as B, in the frame of A. Exact, also as the least
// translation; kSurfaceOnly for an open mesh.
PairDistance HalfSpaceToAny(const ExactGeometry& b, const Pose& X_AB, const SearchLimits& limits);

// Both made of convex pieces, at least one of several, in the frame of A. Exact when separated;
// else the depth of the deepest pair of pieces: at most the least translation, and kBounded by the
// depth of the convex hulls, which is at least that.
PairDistance PiecesToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                            const SearchLimits& limits);

// A mesh as A and convex pieces as B, in the frame of A.
PairDistance MeshToPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                          const SearchLimits& limits);

// Two meshes, in the frame of A.
PairDistance MeshToMesh(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                        const SearchLimits& limits);

// Of anything bounded, in the frame of A: what convex solids around the two are apart, nothing where they
// meet. The hull of a mesh that has one, else its box.
std::optional<double> LowerBoundByEnclosures_m(const ExactGeometry& a, const ExactGeometry& b,
                                               const Pose& X_AB);

// Whether the distance of the pair, as told by the function of the same two, is negative: the first
// parts that overlap end the search.
bool HalfSpaceMeetsAny(const ExactGeometry& b, const Pose& X_AB, WorkCounter* work);
bool PiecesMeetPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                      WorkCounter* work);
bool MeshMeetsPieces(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                     WorkCounter* work);
bool MeshMeetsMesh(const ExactGeometry& a, const ExactGeometry& b, const Pose& X_AB,
                   WorkCounter* work);

// A point inside of two closed meshes whose triangles touch, in the frame of A: see flush_overlap.h.
std::optional<Vector3> PointInTouching(const ExactGeometry& a, const ExactGeometry& b,
                                       const Pose& X_AB, WorkCounter* work);

// Labels a penetrating answer of parts whose depth is at most the true one: kBounded by the depth
// of the convex enclosures, kExact where that leaves nothing open; kSurfaceOnly with an open mesh,
// with the same bound.
PairDistance WithDepthBound(const PairDistance& deepest_part, const ExactGeometry& a,
                            const ExactGeometry& b, const Pose& X_AB);

}  // namespace cwm::collision
