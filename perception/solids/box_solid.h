// Builds a box, with its hidden faces, from two or three orthogonal faces.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "perception/fit/solid.h"

namespace cwm::perception {

// Faces of one box: indices into the fits, two or three of them.
using BoxFaces = std::vector<std::size_t>;

// Returns the largest unused plane that has partners, and its partners: unused planes that are
// orthogonal to it and to each other, touch it, and meet it in a convex edge. Empty if no plane has
// a partner.
std::optional<BoxFaces> FindBoxFaces(const std::vector<ShapeFit>& fits,
                                     const std::vector<char>& used, const FitContext& context);

// Seen faces stay where they were measured. A hidden face lies where the seen ones end, and a
// hidden bottom that ends just above the ground is moved to the ground. Of the 24 frames of a box,
// the one is used whose z is nearest to +-z of the level frame and whose x is then nearest to +-x,
// both made positive.
Solid MakeBox(const BoxFaces& faces, const std::vector<ShapeFit>& fits, const FitContext& context,
              const Ground& ground);

// Returns one of the 24 frames that swap and flip the axes of R, by the rule above.
Matrix3 CanonicalBoxAxes(const Matrix3& R);

}  // namespace cwm::perception
