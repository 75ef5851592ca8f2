// Tests whether an occluder may have divided one object.
#pragma once

#include <cstdint>

#include "perception/cloud/tolerances.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Shares of the places on straight lines between two point sets that are seen through, and that are
// hidden. Precondition: state.sight().
struct VisibilityShares {
  double through = 0, hidden = 0;

  bool IsContradicted() const { return through > kMaxPassing; }
  bool IsHidden() const { return !IsContradicted() && hidden >= kMinSignificantShare; }
};
VisibilityShares VisibilityBetween(const SceneState& state, const PointSet& a, const PointSet& b);

// True if a point lies on the surface of the solid.
bool IsOnSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);
// True if a point lies on the solid's surface extended beyond its ends (ExtendedDistance_m). The
// end caps of cylinders and cones do not count.
bool IsOnExtended(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);

}  // namespace cwm::perception
