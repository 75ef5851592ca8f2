// What a scan itself says against what was said of it: units, sensor, up, pose, normals. Nothing is
// changed for it; whoever sent the scan is told.
#pragma once

#include <string>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/interpret_scene.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

// A warning for each doubt, none for a scan that is what it was said to be. `scene` is the cloud's.
std::vector<std::string> QuestionInput(const PointCloud& cloud, const SegmentedScene& scene,
                                       const InterpretOptions& options);

}  // namespace cwm::perception
