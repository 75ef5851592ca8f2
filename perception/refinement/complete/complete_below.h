// Completes the hidden upper end of a solid that carries another object.
#pragma once

#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Returns the model of a hypothesis that others rest on, if it is one solid that ends below their
// feet: extended up to them, like a solid with a hidden foot down to the support
// (complete_hidden.h). Null if nothing rests on it, if it is not one solid, or if not all points
// were seen from one place.
ModelPtr CompleteBelow(const SceneState& state, const ObjectHypothesis& hypothesis);

}  // namespace cwm::perception
