// Before anything is modelled, parts that the segmentation cut off return to their objects.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// chosen: a handle or a spout comes in as many parts, each beyond the one before.
inline constexpr int kMaxGiftRounds = 4;
// chosen: quantile of heights where a thing has its foot: below are mixed pixels. Of
// kMinHandlePoints the quantile kMixedPixels would be the lowest one.
inline constexpr double kFootQuantile = 0.05;

// Points of one hypothesis that become another one's; all of them, or a part.
struct Gift {
  HypothesisId from, to;
  PointSet points;  // ascending; empty: all
};

// The state after all gifts. What was given may be given on, in no circle; what rested on it rests on
// the last receiver. A hypothesis that gives all is gone.
SceneState Attach(const SceneState& state, std::span<const Gift> gifts);

}  // namespace cwm::perception
