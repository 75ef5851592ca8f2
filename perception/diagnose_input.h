// Checks a scan against what its sender stated: units, sensor, up, pose, normals. Only warns the
// sender; changes nothing.
#pragma once

#include <string>
#include <vector>

#include "perception/cloud/point_cloud.h"
#include "perception/interpret_scene.h"
#include "perception/segmentation/segment_scene.h"

namespace cwm::perception {

struct InputDiagnosis {
  std::vector<std::string> warnings;  // one for each contradiction
  bool scale_is_implausible = false;  // SceneInterpretation::scale_is_implausible
};

// `scene` is the segmented cloud.
InputDiagnosis DiagnoseInput(const PointCloud& cloud, const SegmentedScene& scene,
                             const InterpretOptions& options);

}  // namespace cwm::perception
