// Cuts the rounded rims of round objects. The sharp end of a cylinder or cone extends beyond a
// rounded rim into space that rays crossed.
#pragma once

#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Returns the model of a hypothesis with the visible rims of its cylinders and cones cut at 45
// degrees, if the points near a rim lie inside the sharp end and the best cut has decisive
// evidence. The rest of the end becomes a separate truncated cone after all other shapes, FITTED,
// with the end's points, and the solid is shorter by it. Null if no rim is cut.
ModelPtr CutRoundedRims(const SceneState& state, const ObjectHypothesis& hypothesis,
                        const Work& work);

}  // namespace cwm::perception
