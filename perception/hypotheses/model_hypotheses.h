// The first models of all hypotheses of a scene.
#pragma once

#include <string>
#include <vector>

#include "perception/hypotheses/hypothesis_modeler.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

struct ModelledScene {
  SceneState state;  // all hypotheses have models
  // Hardly anything of the largest objects is a shape: the others have none, and refinement would find
  // none either.
  bool is_shapeless = false;
  std::vector<std::string> warnings;  // of work that was left undone
};

// In parallel, the largest first. Work is bounded by what an image can show: only the largest are looked
// at for objects that touch, and what is smaller than so many others is modelled with reduced effort.
// Throws Stopped when `work` is stopped.
ModelledScene ModelHypotheses(const SceneState& state, const HypothesisModeler& modeler,
                              const ModelingOptions& options, const Work& work);

}  // namespace cwm::perception
