// Builds a thin solid behind a single face that is part of no box.
#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "collision/geometry/polygon.h"
#include "perception/fit/solid.h"

namespace cwm::perception {

// Thickness of a single face whose depth nothing constrains.
// chosen: enough for a collision checker not to step through, too little to invent an object.
inline constexpr double kLoneThickness_m = 0.005;
// A level face no higher than this above the ground becomes a solid down to the ground.
// chosen: books, plates, lids.
inline constexpr double kLowLevel_m = 0.06;

// True for a box behind a single face whose thickness nothing constrained.
bool IsLoneFace(const Shape& shape);

struct Rectangle {
  Vector2 x = Vector2::UnitX();  // unit, one of its edges
  Eigen::AlignedBox2d bounds;    // along x and its left normal
  double area_m2() const { return bounds.volume(); }
  Vector2 center() const {
    return bounds.center().x() * x + bounds.center().y() * Vector2(-x.y(), x.x());
  }
};

// The rectangle of least area around a convex polygon; it has an edge along one of the polygon's
// (Freeman and Shapira 1975).
Rectangle SmallestRectangle(const Polygon& hull);

// Returns a box if the outline is nearly a rectangle, or most of a rectangle whose rest is occluded
// (role COMPLETED; no more rays pass it than mixed pixels explain); else a plate over the convex
// hull of the points. The seen face is where it was measured; the part below the ground is cut off.
// Empty if the points do not fill their outline and no occluder explains that (rays pass the rest
// of it, or there are none): such a face is better meshed.
std::optional<Solid> MakePlaneSolid(const ShapeFit& fit, const FitContext& context,
                                    const Ground& ground);

}  // namespace cwm::perception
