// Where a distance has no gradient: two places are equally near and pull different ways.
#pragma once

namespace cwm::collision {

// Places count as equally near when their distances differ by no more than this: coarse enough for
// central differences with steps of 1e-7 m to stay on one side, fine enough that random points hardly
// ever meet it.
inline constexpr double kKinkReach_m = 1e-6;
// Unit gradients that differ by no more than this are the same one: what is promised of gradients.
inline constexpr double kSameGradient = 1e-6;

}  // namespace cwm::collision
