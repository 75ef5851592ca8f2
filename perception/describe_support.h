// Converts a support of the segmented scene to one of the interpreter's result.
#pragma once

#include <cstdint>
#include <vector>

#include "perception/cloud/work.h"
#include "perception/scene_interpretation.h"
#include "perception/segmentation/segment_scene.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

// States if z = 0 of the world is its floor; only then supports are judged reachable.
enum class WorldFloor { kKnown, kUnknown };

struct DescribedSupport {
  DetectedSupport support;
  std::uint64_t explained = 0;  // points within tolerance (ExplainedWithin_m) of its model
};

// `points` are the scene's, in the level frame L. Points of the support that its plate does not
// explain (its outline is simplified, and the sensor has warp) get a surface of their own.
DescribedSupport DescribeSupport(const SegmentedSupport& segmented, const OrientedPoints& points,
                                 const Pose& X_WL, WorldFloor floor, const SurfaceOptions& options,
                                 const Work& work);

// The support's points that are not within tolerance of its plate: neither over its top face nor
// near its border.
std::vector<std::uint32_t> PointsBeyondPlate(const SegmentedSupport& support,
                                             const OrientedPoints& points, const Work& work);

}  // namespace cwm::perception
