// Whether an occluder may have cut one object in two.
#pragma once

#include <cstdint>

#include "perception/cloud/tolerances.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Of places on straight lines between two point sets, the shares that were seen through and that are
// hidden. Precondition: state.sight().
struct SightBetween {
  double through = 0, hidden = 0;

  bool IsContradicted() const { return through > kMaxPassing; }
  bool IsHidden() const { return !IsContradicted() && hidden >= kNotByChance; }
};
SightBetween LookBetween(const SceneState& state, const PointSet& a, const PointSet& b);

// Whether a point lies on the solid, and on it or on what it would be if it went on.
bool IsOnSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);
bool IsOnExtended(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);

}  // namespace cwm::perception
