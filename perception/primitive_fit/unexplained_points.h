// The points of an object that its solids do not explain.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// chosen: as a share of the points. A smaller connected component is mixed pixels along edges, and
// is too small to be one side of a cut.
inline constexpr double kMinPiece = 0.05;

// One flag per point: 1 if it lies within its distance gate of the surface of any of the solids.
std::vector<char> MarkPointsOnSolids(const std::vector<Solid>& solids, const ModelPoints& points);

// True if the solids explain at least kNearlyAll of the points, and the largest connected component
// of the rest holds less than kMinPiece of all points.
bool IsFullyExplained(const std::vector<Solid>& solids, const FitContext& context);

}  // namespace cwm::perception
