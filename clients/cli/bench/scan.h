// The benchmark's own scan.
#pragma once

#include "clients/formats/cloud_file.h"

namespace cwm::cli {

// A scan by a camera of 640 x 480 pixels of boxes and balls on a table 1 m in front of it and of
// the floor: x y z in its frame (z forward) as F32, with a Kinect's noise, the same on every
// machine.
formats::CloudFile BenchScan();

}  // namespace cwm::cli
