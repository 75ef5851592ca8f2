// The whole pipeline: a cloud in, supports, objects on them with hybrid models, and residual
// geometry out. Reads like section III of the paper.
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
  // The sensor's pose in the world where known. Otherwise the world frame is made: z up, origin at
  // the sensor, x along the sensor's view, projected to the horizontal.
  std::optional<Pose> X_WC;
  // Whether somebody told X_WC, or it is an estimate of an earlier scan that was kept. The world's
  // floor is known from a given pose alone: only then supports are judged reachable or not.
  enum class PoseSource { kGiven, kEstimated };
  PoseSource X_WC_source = PoseSource::kGiven;
  // Up in the sensor's frame, any positive length. Used when X_WC is unknown, which overrules it
  // with a warning (kMaxUpError_rad); without both up is estimated as the normal of the dominant
  // support plane. One that is upside down by what the cloud
  // shows is taken the other way round, and a warning says so; of X_WC a warning says so.
  std::optional<Vector3> up_C;
  Clustering clustering = Clustering::kObjects;
  ModelerOptions modeler;
  // Names of passes that are left out (PassNames of refinement/passes.h), to see what they are worth.
  std::vector<std::string> disabled_passes;
  SurfaceOptions surface;
  int max_threads = 2;
  std::function<int()> threads_now;  // Work::threads_now; may be empty
  std::function<void()> on_piece;    // Work::on_piece; may be empty
};

// InvalidArgument for a cloud that cannot be interpreted at all (no finite point; layout that
// contradicts itself; coordinates beyond kLargestCoordinate_m), naming field, value and rule.
// Cancelled when stopped, within one piece of work of each thread. A cloud without any support is
// not an error: all its points become residual objects and a warning says so. Deterministic: the
// same input gives the same bytes on any number of threads.
absl::StatusOr<SceneInterpretation> InterpretScene(const PointCloud& cloud,
                                                   const InterpretOptions& options,
                                                   std::stop_token stop = {});

}  // namespace cwm::perception
