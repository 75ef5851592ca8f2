// The rounded rims of round objects. The sharp end of a cylinder or cone stands out beyond a rim that
// is rounded, into space that rays crossed.
#pragma once

#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// The model of a hypothesis with the rims that the sensor sees of its cylinders and cones cut at 45
// degrees, where the points about them lie inside the sharp end and the cut that fits them best is worth
// it decisively. What is then left of the end is a truncated cone of its own behind all other shapes,
// FITTED, that holds the end's points; the solid is shorter by it. Null where no rim is cut.
ModelPtr CutRoundedRims(const SceneState& state, const ObjectHypothesis& hypothesis,
                        const Work& work);

}  // namespace cwm::perception
