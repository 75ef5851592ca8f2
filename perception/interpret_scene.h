// The whole pipeline: turns a cloud into supports, objects on them with hybrid models, and residual
// geometry. It follows section III of the paper.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/model/modeler_options.h"
#include "perception/scene_interpretation.h"
#include "perception/segmentation/clustering.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

struct InterpretOptions {
  SensorNoise noise;
  // The sensor's pose in the world, if known. Otherwise the world frame is defined by: z up, origin
  // at the sensor, x along the sensor's view, projected to the horizontal.
  std::optional<Pose> X_WC;
  // The source of X_WC: given, or the estimate of an earlier scan. Only a given pose determines the
  // world's floor, by which supports are judged reachable or not.
  enum class PoseSource { kGiven, kEstimated };
  PoseSource X_WC_source = PoseSource::kGiven;
  // Up in the sensor's frame, of any positive length. X_WC overrules it, with a warning if they
  // differ by more than kMaxUpError_rad. Without both, up is estimated as the normal of the
  // dominant support plane. If the cloud shows that up_C is upside down, the opposite is used, with
  // a warning; for X_WC there is only the warning.
  std::optional<Vector3> up_C;
  Clustering clustering = Clustering::kObjects;
  ModelerOptions modeler;
  // Names of disabled passes (PassNames of refinement/passes.h), to measure the effect of each.
  std::vector<std::string> disabled_passes;
  SurfaceOptions surface;
  int max_threads = 2;
  std::function<int()> threads_now;  // Work::threads_now; may be empty
  std::function<void()> on_chunk;    // Work::on_chunk; may be empty
};

// Returns InvalidArgument, with field, value and rule, for a cloud that cannot be interpreted (no
// finite point, a contradictory layout, coordinates beyond kMaxCoordinate_m). Returns Cancelled
// when stopped, within one piece of work of each thread. A cloud without any support is not an
// error: all its points become residual objects, with a warning. Deterministic: the same input
// gives the same bytes on any number of threads.
absl::StatusOr<SceneInterpretation> InterpretScene(const PointCloud& cloud,
                                                   const InterpretOptions& options,
                                                   std::stop_token stop = {});

}  // namespace cwm::perception
