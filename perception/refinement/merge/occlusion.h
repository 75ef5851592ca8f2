// Whether an occluder may have cut one object in two.
#pragma once

#include <cstdint>

#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Farther apart, parts of one object are not looked for. As of parts that share a plane (join_hidden).
inline constexpr double kMaxOccludedGap_m = 0.35;

// Of places on straight lines between two point sets, the shares that were seen through and that are
// hidden. Precondition: state.sight().
struct SightBetween {
  double through = 0, hidden = 0;

  bool IsContradicted() const { return through > kMaxThrough; }
  bool IsHidden() const { return !IsContradicted() && hidden >= kMinHidden; }

 private:
  static constexpr double kMaxThrough = 0.06;
  static constexpr double kMinHidden = 0.25;
};
SightBetween LookBetween(const SceneState& state, const PointSet& a, const PointSet& b);

// Whether a point lies on the solid, and on it or on what it would be if it went on.
bool IsOnSolid(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);
bool IsOnExtended(const ShapePart& solid, const OrientedPoints& all, std::uint32_t point);

// What one solid explains of a hypothesis that is one solid but for edges; true parts of occluded
// objects had that much and more.
inline constexpr double kMinExplainedAlone = 0.8;

}  // namespace cwm::perception
