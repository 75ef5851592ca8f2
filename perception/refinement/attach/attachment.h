// Before anything is modelled, parts that the segmentation cut off return to their objects.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// Points of one hypothesis that become another one's; all of them, or a part.
struct Gift {
  HypothesisId from, to;
  PointSet points;  // ascending; empty: all
};

// The state after all gifts. What was given may be given on, in no circle; what rested on it rests on
// the last receiver. A hypothesis that gives all is gone.
SceneState Attach(const SceneState& state, std::span<const Gift> gifts);

}  // namespace cwm::perception
