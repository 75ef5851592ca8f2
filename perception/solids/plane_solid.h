// A face without partners becomes a thin solid behind what was seen.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "collision/geometry/polygon.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// A lone face is this thick where nothing tells how thick it is.
// chosen: enough for a collision checker not to step through, too little to invent an object.
inline constexpr double kLoneThickness_m = 0.005;
// Level faces that are no higher above the ground reach it.
// chosen: books, plates, lids.
inline constexpr double kLowLevel_m = 0.06;

// A box of a lone face whose thickness nothing told.
bool IsLoneFace(const Shape& shape);

struct Rectangle {
  Vector2 x = Vector2::UnitX();  // unit, one of its edges
  Eigen::AlignedBox2d bounds;    // along x and its left normal
  double area_m2() const { return bounds.volume(); }
  Vector2 center() const {
    return bounds.center().x() * x + bounds.center().y() * Vector2(-x.y(), x.x());
  }
};

// Around a convex polygon: it has an edge along one of the polygon's (Freeman and Shapira 1975).
Rectangle SmallestRectangle(const Polygon& hull);

// A box where the outline is about a rectangle, or most of a rectangle's whose rest something hides
// (COMPLETED; no more rays pass it than are mixed pixels); else a plate over its convex hull; the
// top (seen) face where it was measured. What would be below the ground is cut off. Nothing where
// the points do not fill their outline though rays were seen to pass the rest of it: such a face is
// better meshed.
std::optional<Solid> MakePlaneSolid(const ShapeFit& fit, const FitContext& context,
                                    const Ground& ground);

}  // namespace cwm::perception
