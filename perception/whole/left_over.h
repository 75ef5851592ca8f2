// What the solids of an object leave of its points.
#pragma once

#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// chosen: of the points; fewer that hang together are mixed pixels along edges, and no side of a
// cut.
inline constexpr double kMinPiece = 0.05;

// Per point: whether it lies on one of them, within its gate.
std::vector<char> OnAny(const std::vector<Solid>& solids, const ModelPoints& points);

// Whether they account for nine tenths of the points, and of the rest no kMinPiece of all hangs
// together.
bool LeaveNoPiece(const std::vector<Solid>& solids, const FitContext& context);

}  // namespace cwm::perception
