// Proposals become states.
#pragma once

#include <span>

#include "perception/refinement/pass.h"

namespace cwm::perception {

// The product as a hypothesis of a state; what rests on another product or on what is consumed rests
// on nothing yet.
ObjectHypothesis HypothesisOf(const Product& product);

// The state in which the products, with their models, replace what is consumed. What rested on the
// consumed rests on their heirs, unless it is reseated.
SceneState Commit(const SceneState& state, const Proposal& proposal,
                  std::span<const ModelPtr> models);

}  // namespace cwm::perception
