// Simple polygons in the plane, metres.
#pragma once

#include <array>
#include <vector>

#include "collision/geometry/pose.h"

namespace cwm {

// A simple (not self-intersecting) polygon, without the first vertex repeated at the end.
using Polygon = std::vector<Vector2>;

// The area of the polygon, positive if the vertices run counter-clockwise.
double SignedArea_m2(const Polygon& polygon);

// True if the polygon contains the point, by the even-odd rule. A point on the border may count
// either way.
bool Contains(const Polygon& polygon, const Vector2& point);

// The point of the border nearest to `point`. The polygon has at least one vertex.
Vector2 NearestOnBorder(const Polygon& polygon, const Vector2& point);

// True when no two edges cross or touch except neighbours at their common vertex.
bool IsSimple(const Polygon& polygon);

// True when outline and holes are simple, every hole lies strictly inside the outline, and no two
// holes touch, cross or contain each other.
bool IsSimpleRegion(const Polygon& outline, const std::vector<Polygon>& holes);

// Counter-clockwise hull (Andrew's monotone chain), without collinear vertices. Fewer than three
// vertices when the points lie on a line.
Polygon ConvexHull(std::vector<Vector2> points);

// Partition of an outline with holes into convex counter-clockwise pieces that cover it exactly and
// overlap only at borders: ear clipping with bridged holes, then merged (Hertel and Mehlhorn 1983).
// Empty when the input is not simple or a hole is not strictly inside.
std::vector<Polygon> ConvexPieces(const Polygon& outline, const std::vector<Polygon>& holes);

// Counter-clockwise triangles, as corners, that cover the same region.
std::vector<std::array<Vector2, 3>> Triangulate(const Polygon& outline,
                                                const std::vector<Polygon>& holes);

// The same triangles as indices into the vertices of the outline followed by those of each hole.
// Every vertex is used, so neighbouring triangles share whole edges.
std::vector<std::array<int, 3>> TriangulateIndices(const Polygon& outline,
                                                   const std::vector<Polygon>& holes);

}  // namespace cwm
