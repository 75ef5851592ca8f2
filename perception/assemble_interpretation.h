// Converts the refined hypotheses of a scan to the interpreter's result (paper, section III, step
// 8).
#pragma once

#include "perception/cloud/work.h"
#include "perception/describe_support.h"
#include "perception/hypotheses/scene_state.h"
#include "perception/scene_interpretation.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

struct AssembleOptions {
  Pose X_WL = Pose::Identity();  // from the level frame to the world: a translation
  WorldFloor floor = WorldFloor::kUnknown;
  SurfaceOptions surface;
};

// Appends supports and objects, with meshes for points that no shape explains, labels the points,
// and counts the explained ones. Precondition: result.labels has one label per point of the cloud,
// and all hypotheses have models. Throws Stopped when `work` is stopped.
void AssembleInterpretation(const SceneState& state, const AssembleOptions& options,
                            const Work& work, SceneInterpretation& result);

}  // namespace cwm::perception
