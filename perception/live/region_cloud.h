// The part of a frame that is interpreted beside the frames.
#pragma once

#include <span>

#include "perception/cloud/point_cloud.h"
#include "perception/live/frame_evidence.h"
#include "perception/live/tracker.h"

namespace cwm::perception {

// An organised cloud of the frame's size with the points of the request's blocks, and around them
// those of what bears them: points that belong to none of the `others`, which are the followed or
// given bodies outside the request. Around the blocks, what differs from what is known belongs to
// another region. All other pixels have no point. The whole view has all points.
// Around new surfaces only the points of supports are taken, since all else was interpreted before.
// Robots, what they carry and mixed pixels are left out.
PointCloud RegionCloud(const FrameEvidence& frame, const RegionRequest& request,
                       std::span<const KnownBody> others);

}  // namespace cwm::perception
