// What the solids of an object leave of its points.
#pragma once

#include <vector>

#include "perception/model/solid.h"

namespace cwm::perception {

// Of an object's points: fewer that hang together are mixed pixels along its edges, and no part that a
// cut would leave.
inline constexpr double kLeastPiece = 0.05;

// Per point: whether it lies on one of them, within its gate.
std::vector<char> OnAny(const std::vector<Solid>& solids, const ModelPoints& points);

// Whether they account for nine tenths of the points and leave no piece that hangs together.
bool AccountForAllPieces(const std::vector<Solid>& solids, const FitContext& context);

}  // namespace cwm::perception
