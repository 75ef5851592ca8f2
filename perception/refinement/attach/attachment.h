// Returns parts that segmentation cut off to their objects, before models are found.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/hypotheses/scene_state.h"

namespace cwm::perception {

// chosen: the number of parts of a handle or a spout, each beyond the one before.
inline constexpr int kMaxTransferRounds = 4;
// chosen: the quantile of heights that is an object's foot; lower points are mixed pixels. Among
// kMinHandlePoints points, the quantile kMixedPixels would be the lowest point.
inline constexpr double kFootQuantile = 0.05;

// Points of one hypothesis that another one receives: all of them, or a part.
struct PointTransfer {
  HypothesisId from, to;
  PointSet points;  // ascending; empty: all
};

// Returns the state after all transfers. A receiver may be given too, but without cycles;
// hypotheses that rested on it then rest on the last receiver. A hypothesis that gives all its
// points is removed.
SceneState Attach(const SceneState& state, std::span<const PointTransfer> transfers);

}  // namespace cwm::perception
