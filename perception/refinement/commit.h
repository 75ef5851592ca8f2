// Applies proposals to states.
#pragma once

#include <span>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// The product as a hypothesis. If it rests on another product or a consumed hypothesis, that is not
// resolved yet.
ObjectHypothesis HypothesisOf(const Product& product);

// Returns the state in which the products, with their models, replace the consumed hypotheses.
// Hypotheses that rested on a consumed one rest on its heir, unless they are reseated.
SceneState Commit(const SceneState& state, const Proposal& proposal,
                  std::span<const ModelPtr> models);

}  // namespace cwm::perception
