// Converts a modelled hypothesis to a hybrid model: shapes, handles, and meshes for other points.
#pragma once

#include <cstdint>
#include <memory>

#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

struct MeshedObject {
  // The object's frame: its origin is the mean of the points, its axes are parallel to the level
  // frame's.
  Pose X_LO = Pose::Identity();
  std::shared_ptr<HybridModel> model;  // in the object's frame
  std::uint64_t explained = 0;         // points within tolerance of the model
};

// Runs steps 7 and 8 (paper, section III). Precondition: the hypothesis has a model. Throws Stopped
// when `work` is stopped.
MeshedObject MeshHypothesis(const ObjectHypothesis& hypothesis, const OrientedPoints& all,
                            const SurfaceOptions& options, const Work& work);

}  // namespace cwm::perception
