// Kinks of a distance: points without a gradient, because two points of the surface are equally
// near in different directions.
#pragma once

namespace cwm::collision {

// chosen: surface points whose distances differ by no more than this count as equally near. Coarse
// enough that central differences with steps of 1e-7 m stay on one side of a kink, fine enough that
// random points hardly ever lie on one.
inline constexpr double kKinkTolerance_m = 1e-6;
// Unit gradients that differ by no more than this count as the same. This is the promised accuracy
// of gradients.
inline constexpr double kGradientTolerance = 1e-6;

}  // namespace cwm::collision
