// Shapes as meshes, for pictures, exports and engines that lack the shape.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

// Segments of a full circle. The upper limit bounds the memory for a huge shape; with it the
// default deviation is met up to a radius of 6.6 m (3.3 m for spheres and capsules).
inline constexpr int kMinSegments = 8;
inline constexpr int kMaxSegments = 256;

// chosen: half a millimetre, less than a depth sensor resolves at half a metre; a cup still needs
// only some hundred triangles.
inline constexpr double kDefaultDeviation_m = 5e-4;

// An outward-wound mesh of the shape in its own frame, its vertices on the surface (an inscribed
// mesh) and watertight; round parts deviate from the surface by at most `max_deviation_m`, as far
// as kMaxSegments allows. A half-space becomes a square of 20 m by 20 m and 1 m depth. Hulls and
// meshes are returned as they are, so that an open mesh stays open.
TriangleMesh Tessellate(const Shape& shape, double max_deviation_m = kDefaultDeviation_m);

// The largest deviation of that mesh from the surface, in metres, by the number of chords that it
// really has; 0 for shapes without round parts. Meaningless for a half-space, whose mesh covers
// only a bounded part of it.
double DeviationBound_m(const Shape& shape, double max_deviation_m = kDefaultDeviation_m);

}  // namespace cwm
