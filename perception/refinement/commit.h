// Applies proposals to states.
#pragma once

#include <span>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// The product as a hypothesis, without id and model. `resting` is copied from the product as it is;
// Commit replaces `on` by the hypothesis of the new state.
ObjectHypothesis HypothesisOf(const Product& product);

// Returns the state in which the products, with their models, replace the consumed hypotheses.
// Hypotheses that rested on a consumed one rest on its successor, unless a resting update says
// otherwise. A product whose model reaches the support rests on the support.
SceneState Commit(const SceneState& state, const Proposal& proposal,
                  std::span<const ModelPtr> models);

}  // namespace cwm::perception
