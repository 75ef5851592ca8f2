// The first models of all hypotheses of a scene.
#pragma once

#include <string>
#include <vector>

#include "perception/hypotheses/hypothesis_modeler.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

struct ModelledScene {
  SceneState state;  // all hypotheses have models
  // Hardly any points of the largest objects are on shapes: the others have no shapes, and
  // refinement would find none.
  bool is_shapeless = false;
  std::vector<std::string> warnings;  // about work that was not done
};

// Models all hypotheses in parallel, the largest first. Work is bounded by what an image can show:
// only the largest are searched for touching objects, and beyond another number the smaller ones
// are modelled with reduced effort. Throws Stopped when `work` is stopped.
ModelledScene ModelHypotheses(const SceneState& state, const HypothesisModeler& modeler,
                              const ModelingOptions& options, const Work& work);

}  // namespace cwm::perception
