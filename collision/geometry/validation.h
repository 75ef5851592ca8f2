// Validation of shapes and meshes sent by clients. All other code relies on these rules.
#pragma once

#include <optional>
#include <string>

#include "collision/geometry/shape.h"

namespace cwm {

// One broken rule, in the words of the error that the user gets.
struct Violation {
  std::string field;  // path below the shape, e.g. "radius_m", "outline[3].x", "triangles[17]"
  std::string value;  // as given, e.g. "-0.1", "nan"
  std::string rule;   // e.g. "must be positive and finite"
};

// Largest coordinate or dimension accepted anywhere, in metres. A relative rounding error of 1e-12,
// that of the closed forms (kernels/README.md), is then at most a micrometre.
inline constexpr double kMaxCoordinate_m = 1e6;

// Smallest dimension accepted, in metres: a nanometre. Its fourth power, 1e-36, is still a normal
// number in single precision.
inline constexpr double kMinDimension_m = 1e-9;

// Limits the cost of a hull's support mapping, which is linear in its vertices. A more detailed
// shape should be sent as a mesh.
inline constexpr int kMaxHullTriangles = 16384;

// Vertices of a plate's outline and holes together. They make about half as many convex pieces,
// each of which is tested by itself in a pair.
inline constexpr int kMaxPlateVertices = 4096;

// The first broken rule of the shape; empty if it is valid. Dimensions must be finite and between
// kMinDimension_m and kMaxCoordinate_m (one radius of a cone may be 0). Outlines must be
// simple, with at least three vertices and at most kMaxPlateVertices in all rings of a plate.
// Meshes must have at least one triangle, indices in range, finite vertices and no triangle that
// uses a vertex twice. Hulls must be watertight, wound outward and convex up to the rounding of
// single-precision coordinates, with at most kMaxHullTriangles. The answer is void if `work` ended
// the search.
std::optional<Violation> FindViolation(const Shape& shape, WorkCounter* work = nullptr);
std::optional<Violation> FindViolation(const TriangleMesh& mesh, WorkCounter* work = nullptr);

}  // namespace cwm
