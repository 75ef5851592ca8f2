#include "perception/diagnose_input.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "perception/segmentation/local_planes.h"
#include "perception/sensor_up.h"

namespace cwm::perception {
namespace {

// chosen: the largest range of points in merged views. Few points lie beyond a sensor's range, and
// a scene that is 100 times too large lies there completely. Maps of many views have their origin
// anywhere in a building.
constexpr double kWidestMap_m = 100;
struct WorkingRange {
  const char* sensor;
  double nearest_m, farthest_m;
};

WorkingRange RangeOf(SensorModel model) {
  switch (model) {
    case SensorModel::kKinect:
      return {"a Kinect", 0.4, 10};
    case SensorModel::kRealSense:
      return {"a RealSense", 0.1, 20};
    case SensorModel::kTimeOfFlight:
      return {"a time of flight camera", 0.1, 20};
    case SensorModel::kTiltingLaser:
      return {"a tilting laser", 0.1, 60};
    case SensorModel::kSickLms400:
      return {"a SICK LMS400", 0.1, 10};
    case SensorModel::kConstant:
      break;
  }
  return {"a sensor of that sigma", 0, kWidestMap_m};
}

// chosen: the share of a sensor's least range below which points are too near. In a body's frame,
// points near the origin may be far from the sensor, which is beside it.
constexpr double kTooNear = 0.25;

// measured: the largest and least plausible scatter of patches in standard deviations. Correlated
// neighbours reduce it, curved patches increase it: the median is 0.5 to 2.1 on simulated scenes of
// all sensors and on real scans of a Kinect.
constexpr double kMaxScatter_sigma = 2.5, kMinScatter_sigma = 0.1;
// chosen: the roughness of the surfaces of tables and boxes.
constexpr double kSmoothness_m = 0.0002;
// chosen: the angle between contradictory normals, half of a right angle.
constexpr double kContradiction_rad = std::numbers::pi / 4;
// chosen: the least number of patches for a statement.
constexpr std::size_t kMinPatches = 16;

void DiagnoseUnits(const SegmentedScene& scene, SensorModel model,
                   std::vector<std::string>& diagnostics) {
  const OrientedPoints& points = scene.points;
  WorkingRange range = RangeOf(model);
  if (!scene.sight) range.farthest_m = kWidestMap_m;
  const double too_near_m = kTooNear * range.nearest_m;
  std::size_t far = 0, near = 0;
  for (const Eigen::Vector3f& p : points.points) {
    const double m2 = (p.cast<double>() - points.viewpoint).squaredNorm();
    far += m2 > range.farthest_m * range.farthest_m;
    near += m2 < too_near_m * too_near_m;
  }
  if (2 * far > points.size()) {
    diagnostics.push_back(absl::StrCat(
        "half of the points are farther away than ", range.farthest_m, " m, where ", range.sensor,
        " sees nothing: coordinates are ", "metres, are these centimetres or millimetres?"));
  }
  if (2 * near > points.size()) {
    diagnostics.push_back(absl::StrCat("half of the points are nearer than ", too_near_m,
                                       " m, where ", range.sensor,
                                       " sees nothing: coordinates are metres"));
  }
}

// Checks a given up; warnings call it by its name in the API.
void DiagnoseUp(const SegmentedScene& scene, const InterpretOptions& options,
                std::vector<std::string>& diagnostics) {
  const bool is_estimate =
      options.X_WC && options.X_WC_source == InterpretOptions::PoseSource::kEstimated;
  if (scene.up_verdict == UpVerdict::kPlausible || is_estimate) return;
  const Vector3 up_C = options.X_WC ? Vector3(scene.R_LC.row(2).transpose()) : *options.up_C;
  const std::string given =
      absl::StrCat(options.X_WC ? "x_world_sensor with up along (" : "up (", up_C.x(), ", ",
                   up_C.y(), ", ", up_C.z(), ") of the sensor's frame");
  if (scene.up_verdict == UpVerdict::kSeenFromBelow) {
    diagnostics.push_back(absl::StrCat(given, " may be upside down: it says that the sensor sees ",
                                       "level surfaces from below alone"));
    return;
  }
  diagnostics.push_back(absl::StrCat(
      given, " seems to be upside down: it says that the sensor sees level surfaces from below; ",
      options.X_WC ? "taken as it is" : "taken the other way round"));
}

void DiagnoseLevel(const SegmentedScene& scene, const InterpretOptions& options,
                   std::vector<std::string>& diagnostics) {
  if (!scene.alternative_up || scene.up_source != UpSource::kGiven) return;
  const double angle_rad = std::acos(std::clamp(scene.alternative_up->z(), -1.0, 1.0));
  if (angle_rad <= kMaxUpError_rad) return;
  diagnostics.push_back(absl::StrCat("what looks most like a support is ",
                                     std::lround(angle_rad * 180 / std::numbers::pi),
                                     " degrees from level by the ", options.X_WC ? "pose" : "up",
                                     " that was given, so it is none"));
}

void DiagnosePose(const InterpretOptions& options, std::vector<std::string>& diagnostics) {
  if (!options.X_WC || !options.up_C || AgreesWithUp(*options.X_WC, *options.up_C)) return;
  const double angle_deg = AngleToUp_rad(*options.X_WC, *options.up_C) * 180 / std::numbers::pi;
  diagnostics.push_back(absl::StrCat("up (", options.up_C->x(), ", ", options.up_C->y(), ", ",
                                     options.up_C->z(), ") contradicts x_world_sensor by ",
                                     std::lround(angle_deg), " degrees: the pose is taken"));
}

void DiagnoseNoise(const std::vector<LocalPlane>& patches, const OrientedPoints& points,
                   const SensorNoise& noise, std::vector<std::string>& diagnostics) {
  std::vector<double> scatter, share;
  for (const LocalPlane& patch : patches) {
    const double sigma_m =
        std::hypot(points.sigma_m[patch.middle], noise.registration_sigma_m, kSmoothness_m);
    scatter.push_back(patch.scatter_m);
    share.push_back(patch.scatter_m / sigma_m);
  }
  if (share.size() < kMinPatches) return;
  const auto middle = static_cast<std::ptrdiff_t>(share.size() / 2);
  for (std::vector<double>* values : {&scatter, &share}) {
    std::nth_element(values->begin(), values->begin() + middle, values->end());
  }
  const double median = share[static_cast<std::size_t>(middle)];
  const double scatter_mm = 1000 * scatter[static_cast<std::size_t>(middle)];
  if (median > kMaxScatter_sigma) {
    diagnostics.push_back(absl::StrFormat(
        "points scatter by %.2g mm about flat patches, %.1f times what the sensor model says: is "
        "it another sensor's, or sigma too small?",
        scatter_mm, median));
  }
  if (noise.model == SensorModel::kConstant && median < kMinScatter_sigma) {
    diagnostics.push_back(absl::StrFormat(
        "points scatter by %.2g mm about flat patches, %.2g of the sigma that was given: small "
        "objects may be missed",
        scatter_mm, median));
  }
}

void DiagnoseNormals(const std::vector<LocalPlane>& patches, const PointCloud& cloud,
                     const OrientedPoints& points, std::vector<std::string>& diagnostics) {
  if (cloud.normals.empty()) return;
  std::size_t asked = 0, contradicted = 0;
  for (const LocalPlane& patch : patches) {
    const Eigen::Vector3f& given = cloud.normals[points.cloud_index[patch.middle]];
    if (!patch.is_flat || !given.allFinite() || given.isZero()) continue;
    ++asked;
    const double cosine = points.normals[patch.middle].cast<double>().dot(patch.normal);
    contradicted += std::abs(cosine) < std::cos(kContradiction_rad);
  }
  if (asked < kMinPatches) return;
  if (2 * contradicted <= asked) return;
  const double part = static_cast<double>(contradicted) / static_cast<double>(asked);
  diagnostics.push_back(absl::StrFormat(
      "normals contradict the surfaces that the points show, by more than %.0f degrees at %.0f %% "
      "of %d places: they are taken as they are",
      kContradiction_rad * 180 / std::numbers::pi, 100 * part, asked));
}

}  // namespace

std::vector<std::string> DiagnoseInput(const PointCloud& cloud, const SegmentedScene& scene,
                                       const InterpretOptions& options) {
  std::vector<std::string> diagnostics;
  DiagnoseUnits(scene, options.noise.model, diagnostics);
  DiagnoseUp(scene, options, diagnostics);
  DiagnoseLevel(scene, options, diagnostics);
  DiagnosePose(options, diagnostics);
  const std::vector<LocalPlane> patches = SampleLocalPlanes(scene.points);
  DiagnoseNoise(patches, scene.points, options.noise, diagnostics);
  DiagnoseNormals(patches, cloud, scene.points, diagnostics);
  return diagnostics;
}

}  // namespace cwm::perception
