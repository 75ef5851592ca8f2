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

// Returns true if the scale is implausible.
bool DiagnoseUnits(const SegmentedScene& scene, SensorModel model,
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
        " sees nothing: coordinates are metres; for millimetres give a scale of 0.001"));
  }
  if (2 * near > points.size()) {
    diagnostics.push_back(absl::StrCat("half of the points are nearer than ", too_near_m,
                                       " m, where ", range.sensor,
                                       " sees nothing: coordinates are metres"));
  }
  return 2 * std::max(far, near) > points.size();
}

// Says that not all points were seen from the origin, unless the sender said so.
void DiagnoseViewpoint(const PointCloud& cloud, const SegmentedScene& scene,
                       std::vector<std::string>& diagnostics) {
  if (scene.sight || !cloud.seen_from_origin) return;
  diagnostics.emplace_back(
      "points hide each other from where they should have been seen, the origin of their frame: "
      "nothing is known about the space before them. If they were seen from one other place, give "
      "viewpoint; if their coordinates are the world's, give frame world");
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
  if (noise.model == SensorModel::kGiven && median < kMinScatter_sigma) {
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

InputDiagnosis DiagnoseInput(const PointCloud& cloud, const SegmentedScene& scene,
                             const InterpretOptions& options) {
  InputDiagnosis diagnosis;
  std::vector<std::string>& diagnostics = diagnosis.warnings;
  diagnosis.scale_is_implausible = DiagnoseUnits(scene, options.noise.model, diagnostics);
  DiagnoseViewpoint(cloud, scene, diagnostics);
  DiagnoseUp(scene, options, diagnostics);
  DiagnoseLevel(scene, options, diagnostics);
  DiagnosePose(options, diagnostics);
  const std::vector<LocalPlane> patches = SampleLocalPlanes(scene.points);
  DiagnoseNoise(patches, scene.points, options.noise, diagnostics);
  DiagnoseNormals(patches, cloud, scene.points, diagnostics);
  return diagnosis;
}

}  // namespace cwm::perception
