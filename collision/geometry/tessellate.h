// Shapes as meshes, for pictures, exports and engines that lack the shape.
#pragma once

#include "collision/geometry/shape.h"

namespace cwm {

// Segments of a full circle. The upper limit bounds the memory that a huge shape may ask for; it
// holds the default deviation up to a radius of 6.6 m (3.3 m for spheres and capsules).
inline constexpr int kMinSegments = 8;
inline constexpr int kMaxSegments = 256;

// Half a millimetre: below what a depth sensor tells apart at half a metre, and still a cup in some
// hundred triangles.
inline constexpr double kDefaultDeviation_m = 5e-4;

// An outward-wound mesh of the shape in its own frame, its vertices on the surface (an inscribed
// mesh) and watertight; round parts deviate from the surface by at most `max_deviation_m`, as far
// as kMaxSegments allows. A half-space becomes a square of 20 m by 20 m and 1 m depth. Hulls and
// meshes are returned as they are, so that an open mesh stays open.
TriangleMesh Tessellate(const Shape& shape, double max_deviation_m = kDefaultDeviation_m);

// How far that mesh deviates at most, by the chords that it really has: 0 for what has no round
// part. Not of a half-space, whose mesh stands for something that has no end.
double DeviationBound_m(const Shape& shape, double max_deviation_m = kDefaultDeviation_m);

}  // namespace cwm
