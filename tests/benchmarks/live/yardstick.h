// The yardstick of the figures of live sensors: the same frames inserted into an OctoMap. Machines
// differ by a factor of three, and each time is quoted beside this one, of the same run.
#pragma once

#include <optional>
#include <vector>

#include "tests/benchmarks/live/recorded_frames.h"

namespace cwm::benchmarks {

inline constexpr double kYardstickVoxel_m = 0.025;

// Milliseconds of processor time of each insertion into a map of voxels of kYardstickVoxel_m, which
// begins empty, by this thread alone: insertPointCloud of all returns, discretized, with the
// sensor's origin (Hornung et al. 2013). Making the points of a depth image does not count. Empty
// if the benchmarks were built without liboctomap-dev.
std::optional<std::vector<double>> InsertIntoOctoMap_ms(const std::vector<RecordedFrame>& frames);

}  // namespace cwm::benchmarks
