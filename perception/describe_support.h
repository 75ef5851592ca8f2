// A support of the segmented scene as the interpreter's result has it.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/scene_interpretation.h"
#include "perception/segmentation/segment_scene.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

// Whether z = 0 of the world is known to be its floor: only then supports are judged reachable.
enum class WorldFloor { kKnown, kUnknown };

struct DescribedSupport {
  DetectedSupport support;
  std::uint64_t explained = 0;  // points within tolerance (ExplainedWithin_m) of its model
};

// `points` are the scene's, in the level frame L. What of the support's points its plate does not
// explain (the outline is simplified, the sensor warps) becomes a surface of its own.
DescribedSupport DescribeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                                 const Pose& X_WL, WorldFloor floor, const SurfaceOptions& options,
                                 const Work& work);

// Those of the support's points that do not lie within tolerance of its plate: neither over its top
// face nor near its border.
std::vector<std::uint32_t> BeyondPlate(const SegmentedSupport& support,
                                       const OrientedPoints& points, const Work& work);

}  // namespace cwm::perception
