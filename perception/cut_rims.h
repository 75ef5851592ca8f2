// The rounded rims of round things. The sharp end of a cylinder or cone stands out beyond a rim that
// is rounded, into space that rays crossed.
#pragma once

#include <cstddef>

#include "perception/model_thing.h"

namespace cwm::perception {

// Cuts the rims that the sensor sees of a thing's cylinders and cones at 45 degrees, where the points
// about them lie inside the sharp end and the cut that fits them best is worth it decisively. What is
// then left of the end is a truncated cone of its own behind all other shapes, FITTED, that holds the
// end's points; the solid is shorter by it.
void CutRoundedRims(const SegmentedScene& scene, std::size_t index, ModelledThing& thing,
                    const Work& work);

}  // namespace cwm::perception
