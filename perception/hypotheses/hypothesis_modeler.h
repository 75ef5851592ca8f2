// Finds the shapes that explain a hypothesis.
#pragma once

#include <functional>
#include <vector>

#include "perception/cloud/sensor_noise.h"
#include "perception/cloud/work.h"
#include "perception/hypotheses/object_hypothesis.h"
#include "perception/hypotheses/scene_rays.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/model/modeler_options.h"

namespace cwm::perception {

struct ModelingOptions {
  SensorNoise noise;
  ModelerOptions modeler;
};

// Runs steps 6 and 7 (paper, section III) for the hypotheses of one scan; surfaces are
// reconstructed later (mesh_hypothesis.h). Models are completed behind occluders
// (complete_hidden.h), because passes need the height of a solid's foot. All methods may run
// concurrently, and throw Stopped when `work` is stopped.
class HypothesisModeler {
 public:
  // `measured` and `work` must outlive the modeler.
  HypothesisModeler(const SegmentedScene& measured, const Work& work);

  ModelPtr Model(const ObjectHypothesis& hypothesis, const ModelingOptions& options) const;

  // Null if `admits` returns false for the shapes, before they are completed.
  using Admission = std::function<bool(const ObjectModel&)>;
  ModelPtr ModelIf(const Admission& admits, const ObjectHypothesis& hypothesis,
                   const ModelingOptions& options) const;

  // The model of a hypothesis with known shapes, in the level frame.
  ModelPtr ModelGiven(const ObjectHypothesis& hypothesis, std::vector<ShapePart> shapes) const;

 private:
  const SegmentedScene& measured_;
  const Work& work_;
  SceneRays rays_;
};

}  // namespace cwm::perception
