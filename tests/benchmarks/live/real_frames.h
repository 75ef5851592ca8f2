// Real depth sequences of CWM_DATA, as frames in memory.
#pragma once

#include <optional>
#include <vector>

#include "tests/benchmarks/live/recorded_frames.h"

namespace cwm::benchmarks {

// Frames of a fixed Asus Xtion over a household scene in which nothing moves, 1/30 s apart. The
// poses are not known. Empty if real/xtion_static is not in CWM_DATA.
std::vector<RecordedFrame> ReadStaticFrames();

// 200 frames of a Kinect that looks around a kitchen in which nothing moves, 1/15 s apart, with the
// poses of the recording in a world whose z points up. Empty if depth_sequence is not in CWM_DATA.
std::vector<RecordedFrame> ReadMovingFrames();

}  // namespace cwm::benchmarks
