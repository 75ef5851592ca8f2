// Two or three orthogonal faces become a box with its hidden faces.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// Faces of one box: indices into the fits, two or three of them.
using BoxFaces = std::vector<std::size_t>;

// The largest unused plane and the planes that are orthogonal to it and to each other, touch it,
// and lie behind it (a convex edge); nothing when no unused plane has such a neighbour.
std::optional<BoxFaces> FindBoxFaces(const std::vector<ShapeFit>& fits,
                                     const std::vector<char>& used, const FitContext& context);

// Faces that were seen lie where they were measured. A hidden face lies where the seen ones end;
// the bottom of a box that ends just above the ground lies on the ground. Of the 24 frames of a box
// the one is taken whose z is nearest to +-z of the level frame, then x nearest to +-x, both
// positive.
Solid MakeBox(const BoxFaces& faces, const std::vector<ShapeFit>& fits, const FitContext& context,
              const Ground& ground);

// The frame among the 24 that swap and flip the axes of R, by the rule above.
Matrix3 CanonicalBoxAxes(const Matrix3& R);

}  // namespace cwm::perception
