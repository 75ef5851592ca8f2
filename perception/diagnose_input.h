// Checks a scan against what its sender stated: units, sensor, up, pose, normals. Only warns the
// sender; changes nothing.
#pragma once

#include <string>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/interpret_scene.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

// Returns one warning for each contradiction. `scene` is the segmented cloud.
std::vector<std::string> DiagnoseInput(const PointCloud& cloud, const SegmentedScene& scene,
                                       const InterpretOptions& options);

}  // namespace cwm::perception
