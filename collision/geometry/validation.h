// What a client may not send: the rules that every shape and mesh obeys inside.
#pragma once

#include <optional>
#include <string>

#include "collision/geometry/shape.h"

namespace cwm {

// One broken rule, in words that an error to the user is made of.
struct Violation {
  std::string field;  // path below the shape, e.g. "radius_m", "outline[3].x", "triangles[17]"
  std::string value;  // as given, e.g. "-0.1", "nan"
  std::string rule;   // e.g. "must be positive and finite"
};

// Largest coordinate or dimension accepted anywhere, metres. Beyond it, squares lose the last
// micrometre in double precision.
inline constexpr double kLargestCoordinate_m = 1e6;

// Smallest dimension accepted, metres: a nanometre. Below it, squares of squares underflow.
inline constexpr double kSmallestDimension_m = 1e-9;

// Support mappings of a hull are linear in its vertices; more detail belongs into a mesh.
inline constexpr int kMostHullTriangles = 16384;

// Vertices of a plate's outline and holes together: its convex pieces are about half as many, and
// each is one of the shapes that a pair is asked about.
inline constexpr int kMostPlateVertices = 4096;

// The first broken rule of the shape, or nothing. Dimensions must be finite and between
// kSmallestDimension_m and kLargestCoordinate_m (one radius of a cone may be 0); outlines simple
// with at least three vertices and at most kMostPlateVertices in all rings of a plate; meshes have at least one triangle, indices in range, finite
// vertices and no triangle that uses a vertex twice; hulls are watertight, outward-wound and convex
// up to the rounding of single-precision coordinates.
std::optional<Violation> FindViolation(const Shape& shape, WorkCounter* work = nullptr);
std::optional<Violation> FindViolation(const TriangleMesh& mesh, WorkCounter* work = nullptr);

}  // namespace cwm
