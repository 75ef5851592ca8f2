// The parts of a frame that show something where the world has nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/live/frame_evidence.h"

namespace cwm::perception {

// Those of the blocks, ascending, in which a frame of a sensor at rest shows what has come and is
// nearer than all of the bodies, which were interpreted since: an obstacle that is no object.
// Tolerances are those of single pixels (DepthNoise::Explained_m), and what is as small as noise
// does not count.
std::vector<std::int32_t> UnmodelledBlocks(const FrameEvidence& frame,
                                           std::span<const std::int32_t> blocks,
                                           std::span<const KnownBody> bodies);

}  // namespace cwm::perception
