// A scan of a benchmark's own.
#pragma once

#include "clients/formats/cloud_file.h"

namespace cwm::cli {

// What a camera of 640 x 480 pixels sees of boxes and balls on a table 1 m in front of it and of the
// floor: x y z in its frame (z forward) as F32, with the noise of a Kinect, the same on every
// machine.
formats::CloudFile BenchScan();

}  // namespace cwm::cli
