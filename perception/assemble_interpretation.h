// The refined hypotheses of a scan as the interpreter's result (paper, section III, step 8).
#pragma once

#include "perception/cloud/work.h"
#include "perception/describe_support.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/scene_interpretation.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

struct AssembleOptions {
  Pose X_WL = Pose::Identity();  // the level frame in the world: a translation
  WorldFloor floor = WorldFloor::kUnknown;
  SurfaceOptions surface;
};

// Appends supports and objects, with meshes for what of their points no shape explains, labels the
// points, and counts what is explained. Precondition: result.labels has one label for each point of the
// cloud, and all hypotheses have models. Throws Stopped when `work` is stopped.
void AssembleInterpretation(const SceneState& state, const AssembleOptions& options,
                            const Work& work, SceneInterpretation& result);

}  // namespace cwm::perception
