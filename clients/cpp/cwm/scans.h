// Scans: points in, what the world made of them out.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cwm/namespace.h"
#include "cwm/objects.h"

namespace cwm::CWM_API {

// kUpdate replaces what is in view, kAdd removes and moves nothing, kSegmentOnly leaves the world
// as it is.
enum class IngestMode { kUpdate = 1, kAdd, kSegmentOnly };
// The frame of the points: the sensor's, or the world's, where z is up.
enum class CloudFrame { kSensor = 1, kWorld };
// Whether what stands on a support is divided before shapes are searched; kNone is for dense
// clutter.
enum class Clustering { kObjects = 1, kNone };

// The standard deviation of a sensor's noise, from which all thresholds follow.
enum class SensorModel { kKinect = 1, kRealsense, kTimeOfFlight, kTiltingLaser };
// a + b z^2 metres at depth z. Of merged views give the error of their registration as a_m.
struct SensorNoise {
  double a_m = 0;
  double b_per_m = 0;
};

struct ScanOptions {
  // The sensor's pose. Absent: estimated once for each sensor_name, with `up` if given.
  std::optional<Eigen::Isometry3d> X_WS = {};
  std::optional<Eigen::Vector3d> up_S = {};  // of any positive length
  std::variant<SensorModel, SensorNoise> sensor = SensorModel::kKinect;
  std::string sensor_name = {};
  // Columns x y z of points that form an image, row by row: its height in pixels. 1: a list.
  int height = 1;
  Eigen::Matrix3Xf normals = {};  // like the points; empty: none
  IngestMode mode = IngestMode::kUpdate;
  bool labels = true;
  Clustering clustering = Clustering::kObjects;
  bool search_planes = true;
  bool search_cylinders = true;
  bool search_spheres = true;
  bool search_cones = true;
  CloudFrame frame = CloudFrame::kSensor;
  // The place that the points were seen from, in their frame, metres. Absent: the origin, or
  // unknown in the world's frame.
  std::optional<Eigen::Vector3d> viewpoint = {};
  double scale = 1;    // metres per unit of the points; 0.001: millimetres
  bool force = false;  // takes a scan that contradicts the world
  std::optional<double> time_budget_s = {};
  std::optional<std::int64_t> expected_revision = {};
};

// Points by what became of them.
struct IngestReport {
  std::int64_t points_in = 0;
  std::int64_t points_finite = 0;
  std::int64_t points_explained = 0;
  std::int64_t points_rejected = 0;
  std::vector<std::string> warnings = {};
  // The view did not change since it was interpreted: the known objects were returned, and nothing
  // was interpreted.
  bool unchanged_view = false;
};

// The changes of the world by the scan, by name.
struct IngestChanges {
  std::vector<std::string> added = {};
  std::vector<std::string> moved = {};
  std::vector<std::string> replaced = {};
  std::vector<std::string> removed = {};
  std::vector<std::string> kept = {};
  std::vector<std::string> occluded = {};
};

struct IngestResult {
  std::string world_uid = {};  // empty: no world holds it (kSegmentOnly)
  std::int64_t revision = 0;
  Eigen::Isometry3d X_WS = Eigen::Isometry3d::Identity();  // given or estimated
  IngestReport report = {};
  std::vector<Object> supports = {};
  std::vector<Object> objects = {};
  IngestChanges changes = {};
  std::vector<std::pair<std::string, double>> stages_ms = {};
  // One per point: 0 is unexplained, 1 to 9 the supports (the tenth and later share 9), object i
  // (from 1) has 10 (i + 1) + part. Empty if none were wanted.
  std::vector<std::uint32_t> labels = {};

  // The indices of the points of a support or an object of this result, by its name. Throws Error:
  // kNotFound for another name, kFailedPrecondition without labels.
  std::vector<Eigen::Index> PointsOf(const std::string& name) const;
};

}  // namespace cwm::CWM_API
