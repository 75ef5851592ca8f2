// A support of the segmented scene as the interpreter's result has it.
#pragma once

#include <cstdint>

#include "perception/cloud/work.h"
#include "perception/scene/segment_scene.h"
#include "perception/scene_interpretation.h"

namespace cwm::perception {

// Whether z = 0 of the world is known to be its floor: only then supports are judged reachable.
enum class WorldFloor { kKnown, kUnknown };

// `points` are the scene's, in the level frame L.
DetectedSupport DescribeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                                const Pose& X_WL, WorldFloor floor);

// How many of the support's points lie within tolerance (ExplainedWithin_m) of its plate: over its
// top face, or near its border.
std::uint64_t ExplainedBySupport(const SegmentedSupport& support, const OrientedPoints& points,
                                 const Work& work);

}  // namespace cwm::perception
