// The whole pipeline: a cloud in, supports, objects on them with hybrid models, and residual
// geometry out. Reads like section III of the paper.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "collision/geometry/hybrid_model.h"
#include "perception/cloud/point_cloud.h"
#include "perception/cloud/sensor_noise.h"
#include "perception/model/object_modeler.h"
#include "perception/surface/surface_reconstruction.h"

namespace cwm::perception {

struct InterpretOptions {
  SensorNoise noise;
  // The sensor's pose in the world where known. Otherwise the world frame is made: z up, origin at
  // the sensor, x along the sensor's view, projected to the horizontal.
  std::optional<Pose> X_WC;
  // Up in the sensor's frame, any positive length. Used when X_WC is unknown; without it up is
  // estimated as the normal of the dominant support plane.
  std::optional<Vector3> up_C;
  ModelerOptions modeler;
  SurfaceOptions surface;
  int max_threads = 2;
  std::function<void()> on_piece;  // Work::on_piece; may be empty
};

// A horizontal surface that things can stand on. Its frame has z up and z = 0 in the top face; its
// model is one Plate: its top face was measured, as its quality says; its body, kPlateThickness_m, was
// supplied, so its role is COMPLETED.
struct DetectedSupport {
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;
  // Set when the sensor's pose was given: top between 0.35 and 1.5 m above the world's floor z = 0
  // (paper, IV).
  std::optional<bool> reachable;
  int point_count = 0;
};

enum class DetectedKind { kObject, kResidual };  // on a support, or neither support nor object

struct DetectedObject {
  DetectedKind kind = DetectedKind::kObject;
  Pose X_WO = Pose::Identity();
  std::shared_ptr<const HybridModel> model;  // in the object's frame
  int supported_by = -1;  // index into supports: the one below, at the bottom of a stack; -1 for residuals
  int rests_on = -1;      // index into objects: what is between it and the support; -1 for nothing
  std::vector<Eigen::Vector3f>
      points_W;  // its measured points, thinned to about 4 mm, for association
};

struct StageTime {
  std::string stage;  // "normals", "supports", "clusters", "split", "shapes", "surfaces"
  double elapsed_ms = 0;
};

struct InterpretReport {
  std::uint64_t points_in = 0;
  std::uint64_t points_finite = 0;
  std::uint64_t points_explained =
      0;  // within tolerance of a support, a shape, a handle or a surface
  std::uint64_t points_rejected = 0;  // finite, labelled 0: isolated points that belong to nothing
  std::vector<std::string> warnings;
  std::vector<StageTime> stages;
};

struct SceneInterpretation {
  Pose X_WC = Pose::Identity();  // given or estimated
  std::vector<DetectedSupport> supports;
  std::vector<DetectedObject> objects;  // objects first, then residuals
  // One label per input point: 0 none, 1-9 supports, object i (from 1, in the order above,
  // residuals included) 10 * (i + 1) + part, part 0 the object as such, 1-9 its parts.
  std::vector<std::uint32_t> labels;
  InterpretReport report;
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
