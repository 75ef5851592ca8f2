// What carries another object reaches up to it, also where that hides its upper end.
#pragma once

#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// The model of a hypothesis on which others rest, if it is one solid that ends below their feet: it is
// lengthened up to them, as what hides its own foot is down to the support (complete_hidden.h). Null
// where nothing changes, or not all was seen from one place.
ModelPtr CompleteBelow(const SceneState& state, const ObjectHypothesis& hypothesis);

}  // namespace cwm::perception
